// Bounds that the device finds equal BoundsGrid's to the bit.
#include <gtest/gtest.h>

#include <cstring>

#include "backends/bounds_cases.h"
#include "backends/emulated_device.h"
#include "lumisweep/volume/majorant_grid.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

void expect_equal(const ScalarGrid& volume)
{
    const Stream stream;
    const test::VolumeOnDevice on_device(volume, stream);
    const DeviceBounds& bounds = on_device.bounds;
    const BoundsGrid expected(volume);

    const RawRange range = raw_range(volume);
    EXPECT_EQ(std::memcmp(&bounds.raw_range(), &range, sizeof(range)), 0)
        << bounds.raw_range().low << " … " << bounds.raw_range().high << ", not " << range.low << " … " << range.high;
    const WholeBounds &whole = bounds.whole(), &other = expected.whole();
    EXPECT_EQ(std::memcmp(&whole.scale, &other.scale, sizeof(whole.scale)), 0);
    EXPECT_EQ(whole.volume_size, other.volume_size);
    EXPECT_EQ(whole.range.low, other.range.low);
    EXPECT_EQ(whole.range.high, other.range.high);
    EXPECT_EQ(whole.block_side, other.block_side);
    EXPECT_EQ(whole.diagonal, other.diagonal);
    EXPECT_EQ(whole.has_gaps, other.has_gaps);

    ASSERT_EQ(bounds.block_count(), expected.blocks());
    std::vector<CellBounds> blocks(bounds.block_count());
    std::vector<BoundsRow> cells(blocks.size() * rows_of_block);
    copy_to_host(blocks.data(), bounds.blocks(), blocks.size() * sizeof(CellBounds), stream);
    copy_to_host(cells.data(), bounds.cells(), cells.size() * sizeof(BoundsRow), stream);
    stream.wait();
    EXPECT_EQ(std::memcmp(blocks.data(), &expected.block(0), blocks.size() * sizeof(CellBounds)), 0);
    EXPECT_EQ(std::memcmp(cells.data(), expected.cells(0), cells.size() * sizeof(BoundsRow)), 0);
    EXPECT_EQ(bounds.bytes(), expected.bytes());
}

TEST(DeviceBoundsTest, EqualTheHosts)
{
    for (const Vec3i& size : test::sizes_of_volumes()) {
        SCOPED_TRACE(testing::Message() << size.x << " × " << size.y << " × " << size.z);
        int k = 0;
        for (const ScalarGrid& volume : test::volumes_of(size)) {
            SCOPED_TRACE(k++);
            expect_equal(volume);
        }
    }
}

// A value far from all others takes its cells to the ends of the range, wherever it lies.
TEST(DeviceBoundsTest, EqualTheHostsForSingleVoxels)
{
    std::mt19937 random(73);
    for (int i = 0; i < 60; ++i) {
        ScalarGrid volume(VoxelType::f32, {17, 16, 9}, Affine3d{});
        for (std::size_t k = 0; k < volume.voxel_count(); ++k)
            volume.voxels<float>()[k] = static_cast<float>(k % 7);
        volume.voxels<float>()[random() % volume.voxel_count()] = i % 2 == 0 ? -1e6F : 1e6F;
        expect_equal(volume);
    }
}

TEST(DeviceBoundsTest, UploadNoVoxels)
{
    const Stream stream;
    const ScalarGrid volume(VoxelType::f32, {64, 64, 64}, Affine3d{});
    test::VolumeOnDevice on_device(volume, stream);
    const std::uint64_t before = test::bytes_uploaded();
    on_device.bounds.build(on_device.voxels.data(), volume, stream);
    EXPECT_LT(test::bytes_uploaded() - before, 100U);
}

} // namespace
} // namespace lumisweep::LUMISWEEP_CUDA
