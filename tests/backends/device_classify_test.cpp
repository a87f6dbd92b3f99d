// Classification on the device against the host's, to the byte, margins and all.
#include "lumisweep/backends/cuda/device_classify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "backends/emulated_device.h"
#include "lumisweep/base/error.h"
#include "lumisweep/visibility/extinction_grid.h"
#include "support/random_function.h"
#include "visibility/generated_volumes.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

using namespace test;

/// A volume on the device, classified there by whatever transfer function.
class OnDevice {
public:
    explicit OnDevice(const ScalarGrid& volume) : volume_(volume), range_(raw_range(volume))
    {
        voxels_.upload({volume.data(), volume.bytes()}, "the volume", stream_);
    }
    /// Uploads what an edit uploads.
    const DeviceExtinction& classify(const TransferFunction& tf, int mip_level)
    {
        tf_.upload(tf, stream_);
        classify_.classify(extinction_, voxels_.data(), volume_, range_, tf, tf_, mip_level, stream_);
        return extinction_;
    }
    const RawRange& range() const { return range_; }
    const Stream& stream() const { return stream_; }

private:
    const ScalarGrid& volume_;
    RawRange range_;
    Stream stream_;
    DeviceArray<std::byte> voxels_;
    DeviceTransferFunction tf_;
    DeviceClassify classify_;
    DeviceExtinction extinction_;
};

/// Rows of `length` voxels without margins, against rows with them.
::testing::AssertionResult same_rows(const AlignedArray<std::uint8_t>& expected, int length,
                                     const DeviceArray<std::uint8_t>& rows, const Stream& stream)
{
    const auto n = static_cast<std::size_t>(length), pitch = static_cast<std::size_t>(row_pitch(length));
    std::vector<std::uint8_t> bytes(rows.size());
    rows.download(bytes, stream);
    stream.wait();
    if (bytes.size() != expected.size() / n * pitch)
        return ::testing::AssertionFailure() << bytes.size() << " bytes in rows of " << pitch;
    for (std::size_t row = 0; row < expected.size() / n; ++row)
        for (std::size_t b = 0; b < pitch; ++b) {
            const std::size_t i = b < row_margin ? 0 : std::min<std::size_t>(b - row_margin, n - 1);
            if (bytes[row * pitch + b] != expected[row * n + i])
                return ::testing::AssertionFailure()
                       << "row " << row << ", byte " << b << ": " << int{bytes[row * pitch + b]} << ", not "
                       << int{expected[row * n + i]};
        }
    return ::testing::AssertionSuccess();
}

void expect_same(OnDevice& device, const ScalarGrid& volume, const TransferFunction& tf, int level)
{
    SCOPED_TRACE(::testing::Message() << name_of(volume.type()) << ' ' << volume.size().x << " x " << volume.size().y
                                      << " x " << volume.size().z << ", level " << level << ", " << tf.points().size()
                                      << " points");
    const ExtinctionGrid expected = classify(volume, device.range(), tf, level);
    const DeviceExtinction& extinction = device.classify(tf, level);
    EXPECT_EQ(extinction.volume_size, expected.volume_size);
    EXPECT_EQ(extinction.world_from_voxel.offset, expected.world_from_voxel.offset);
    EXPECT_EQ(extinction.mip_level, level);
    ASSERT_EQ(extinction.size, expected.size);
    EXPECT_EQ(extinction.scale, expected.scale);
    if (!(expected.scale > 0.0F))
        return;
    EXPECT_TRUE(same_rows(expected.stored, expected.size.x, extinction.straight, device.stream()));
    EXPECT_TRUE(same_rows(expected.transposed, expected.size.y, extinction.transposed, device.stream()));
}

/// The same content in each type, as far as it holds it; floats with some that are not finite.
std::vector<ScalarGrid> volumes_of_all_types(Vec3i size)
{
    std::vector<ScalarGrid> volumes;
    volumes.push_back(smoke_volume(size, oblique()));
    volumes.emplace_back(VoxelType::u8, size, Affine3d{}, 4.3, 20.0);
    volumes.emplace_back(VoxelType::u16, size, Affine3d{}, -1.0, 900.0);
    volumes.emplace_back(VoxelType::f32, size, Affine3d{}, 1.7, 3.0);
    std::mt19937 random(static_cast<unsigned>(size.x));
    for (std::size_t v = 0; v < volumes[0].voxel_count(); ++v) {
        auto& value = volumes[0].voxels<std::int16_t>()[v];
        value = static_cast<std::int16_t>(value - 100 + static_cast<int>(random() % 200));
        volumes[1].voxels<std::uint8_t>()[v] = static_cast<std::uint8_t>(value / 4);
        volumes[2].voxels<std::uint16_t>()[v] = static_cast<std::uint16_t>(value);
        volumes[3].voxels<float>()[v] = static_cast<float>(value) * 0.61F;
    }
    for (std::size_t v = 5; v < volumes[3].voxel_count(); v += 97)
        volumes[3].voxels<float>()[v] = v % 2 == 0 ? std::numeric_limits<float>::quiet_NaN() : 3e38F;
    return volumes;
}

TEST(DeviceClassifyTest, SameAsOnTheHost)
{
    std::mt19937 random(17);
    std::vector<TransferFunction> functions{smoke(), TransferFunction({{400.0, 1.0}}),
                                            TransferFunction({{200.0, 0.0}, {200.0, 3.0}, {500.0, 3.0}, {500.0, 0.0}})};
    for (const int points : {13, 14, 15, 60})
        functions.push_back(test::random_function(points, random, 0.7));
    for (const Vec3i size :
         {Vec3i{1, 1, 1}, {3, 2, 5}, {64, 16, 3}, {131, 77, 5}, {7, 130, 4}, {68, 33, 9}, {2, 3, 300}, {145, 259, 2}})
        for (const ScalarGrid& volume : volumes_of_all_types(size)) {
            OnDevice device(volume);
            for (const TransferFunction& tf : functions)
                for (const int level : {0, 1, 2, 3, 4, 9})
                    expect_same(device, volume, tf, level);
        }
}

TEST(DeviceClassifyTest, LargestSumsFit)
{
    // More than 32 bits hold, in one level voxel.
    ScalarGrid volume(VoxelType::u8, {150, 64, 40}, Affine3d{});
    std::fill_n(volume.voxels<std::uint8_t>(), volume.voxel_count(), std::uint8_t{255});
    OnDevice device(volume);
    for (const int level : {2, 5, 6, 7, 8, 13})
        expect_same(device, volume, TransferFunction({{0.0, 0.0}, {255.0, 1.0}}), level);
}

TEST(DeviceClassifyTest, AnEditUploadsOnlyItsTransferFunction)
{
    const ScalarGrid volume = smoke_volume({40, 30, 20}, Affine3d{});
    OnDevice device(volume);
    device.classify(smoke(), 0);
    const std::uint64_t before = bytes_uploaded();
    device.classify(bone(), 0);
    EXPECT_LE(bytes_uploaded() - before, 4096U);
    device.classify(bone(), 1);
    EXPECT_LE(bytes_uploaded() - before, 8192U);
}

TEST(DeviceClassifyTest, EmptyVolumesHaveNoScale)
{
    const ScalarGrid volume = smoke_volume({20, 10, 5}, Affine3d{});
    OnDevice device(volume);
    EXPECT_GT(device.classify(smoke(), 0).scale, 0.0F);
    EXPECT_EQ(device.classify(TransferFunction({{0.0, 0.0}}), 0).scale, 0.0F);
    expect_same(device, volume, smoke(), 0);
    EXPECT_THROW(device.classify(smoke(), 14), Error);
}

} // namespace
} // namespace lumisweep::LUMISWEEP_CUDA
