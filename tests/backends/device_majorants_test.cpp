// Majorants that the device makes equal MajorantGrid's to the bit.
#include "lumisweep/backends/cuda/device_majorants.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "backends/bounds_cases.h"
#include "backends/emulated_device.h"
#include "lumisweep/volume/majorant_grid.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

/// The points of a transfer function in the device's memory.
struct PointsOnDevice {
    DeviceArray<TransferPoint> points;
    TransferPointsView view;

    PointsOnDevice(const TransferFunction& transfer_function, const Stream& stream)
        : view(transfer_function.points_view())
    {
        points.upload({view.points, static_cast<std::size_t>(view.count)}, "points", stream);
        view.points = points.data();
    }
};

struct Seen {
    int thin = 0, with_cells = 0, far_blocks = 0;
};

/// `majorants` may hold those of another transfer function, or of another volume.
void expect_equal(const DeviceBounds& bounds, const BoundsGrid& bounds_of_host, const TransferFunction& tf,
                  DeviceMajorants& majorants, Seen& seen)
{
    const Stream stream;
    const MajorantGrid grid(bounds_of_host, tf);
    const MajorantView expected = grid.view();
    majorants.build(bounds, PointsOnDevice(tf, stream).view, stream);
    MajorantView view = majorants.view();
    const std::size_t n = bounds.block_count();
    std::vector<std::uint8_t> blocks(n), cells(n * majorant_block_cells), smallest(n);
    copy_to_host(blocks.data(), view.blocks, n, stream);
    copy_to_host(cells.data(), view.cells, cells.size(), stream);
    ASSERT_EQ(view.smallest == nullptr, expected.smallest == nullptr);
    if (view.smallest != nullptr) {
        copy_to_host(smallest.data(), view.smallest, n, stream);
        EXPECT_EQ(std::memcmp(smallest.data(), expected.smallest, n), 0);
        ++seen.thin;
    }
    stream.wait();
    EXPECT_EQ(view.largest, expected.largest);
    ASSERT_EQ(std::memcmp(blocks.data(), expected.blocks, n), 0);
    for (std::size_t block = 0; block < n; ++block)
        if (blocks[block] == 0) { // in others cells are not read
            const std::size_t at = block * majorant_block_cells;
            ASSERT_EQ(std::memcmp(cells.data() + at, expected.cells + at, majorant_block_cells), 0);
            ++seen.with_cells;
        } else {
            seen.far_blocks += blocks[block] > 1 && blocks[block] < empty_block ? 1 : 0;
        }
    EXPECT_EQ(view.size, expected.size);
    EXPECT_EQ(view.stride_y, expected.stride_y);
    EXPECT_EQ(view.stride_z, expected.stride_z);
    EXPECT_EQ(view.shift_y, expected.shift_y);
    EXPECT_EQ(view.shift_z, expected.shift_z);
    EXPECT_GE(majorants.bytes(), grid.bytes());
}

TEST(DeviceMajorantsTest, EqualTheHosts)
{
    const Stream stream;
    const std::vector<TransferFunction> functions = test::transfer_functions();
    Seen seen;
    int k = 0;
    for (const double side : {1.0, 40.0})
        for (const Vec3i& size : test::sizes_of_volumes()) {
            SCOPED_TRACE(testing::Message() << size.x << " × " << size.y << " × " << size.z);
            DeviceMajorants majorants;
            for (const ScalarGrid& volume : test::volumes_of(size, side)) {
                SCOPED_TRACE(k);
                const test::VolumeOnDevice on_device(volume, stream);
                const BoundsGrid bounds(volume);
                for (int i = 0; i < 2; ++i) // two of them each time, so that every volume and size meets all
                    expect_equal(on_device.bounds, bounds, functions[static_cast<std::size_t>(k++) % functions.size()],
                                 majorants, seen);
            }
        }
    EXPECT_GT(seen.thin, 100);
    EXPECT_GT(seen.with_cells, 100);
}

// Few voxels that are not empty in large spaces, along every axis.
TEST(DeviceMajorantsTest, MeasureEmptySpaceAsTheHostDoes)
{
    const Stream stream;
    const TransferFunction tf({{100.0, 0.0}, {200.0, 1.0}});
    std::mt19937 random(74);
    Seen seen;
    DeviceMajorants majorants;
    for (const Vec3i& size : {Vec3i{64, 50, 70}, Vec3i{300, 9, 9}, Vec3i{7, 1, 300}, Vec3i{20, 400, 30}})
        for (const int voxels : {0, 1, 3, 40}) {
            ScalarGrid volume(VoxelType::u8, size, Affine3d{});
            for (int i = 0; i < voxels; ++i)
                volume.voxels<std::uint8_t>()[random() % volume.voxel_count()] = 200;
            expect_equal(test::VolumeOnDevice(volume, stream).bounds, BoundsGrid(volume), tf, majorants, seen);
        }
    EXPECT_GT(seen.far_blocks, 1000);
}

TEST(DeviceMajorantsTest, AnEditUploadsNothingAndTakesNoMemory)
{
    const Stream stream;
    const std::vector<ScalarGrid> volumes = test::volumes_of({64, 40, 33});
    const test::VolumeOnDevice on_device(volumes.front(), stream);
    DeviceMajorants majorants;
    for (const TransferFunction& tf : test::transfer_functions()) // thin media among them
        majorants.build(on_device.bounds, PointsOnDevice(tf, stream).view, stream);
    const std::uint64_t taken = test::emulated_memory_taken();
    for (const TransferFunction& tf : test::transfer_functions()) {
        const PointsOnDevice points(tf, stream);
        const std::uint64_t before = test::bytes_uploaded();
        majorants.build(on_device.bounds, points.view, stream);
        EXPECT_EQ(test::bytes_uploaded(), before);
    }
    EXPECT_EQ(test::emulated_memory_taken(), taken);
}

} // namespace
} // namespace lumisweep::LUMISWEEP_CUDA
