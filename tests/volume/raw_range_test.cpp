#include "lumisweep/volume/raw_range.h"

#include <gtest/gtest.h>

#include <limits>

namespace lumisweep {
namespace {

template <class T>
RawRange range_with(VoxelType type, T low, T high)
{
    ScalarGrid grid(type, {9, 5, 3}, Affine3d{}, -2.0, 7.0);
    grid.voxels<T>()[61] = low;
    grid.voxels<T>()[134] = high;
    return raw_range(grid);
}

TEST(RawRange, IsExactForEveryVoxelType)
{
    EXPECT_EQ(range_with<std::uint8_t>(VoxelType::u8, 0, 255).high, 255.0F);
    EXPECT_EQ(range_with<std::uint16_t>(VoxelType::u16, 3, 65535).high, 65535.0F);
    EXPECT_EQ(range_with<std::uint16_t>(VoxelType::u16, 3, 65535).low, 0.0F);
    const RawRange i16 = range_with<std::int16_t>(VoxelType::i16, -32768, 32767);
    EXPECT_EQ(i16.low, -32768.0F);
    EXPECT_EQ(i16.high, 32767.0F);
    const RawRange f32 = range_with<float>(VoxelType::f32, -3e38F, 1e-40F);
    EXPECT_EQ(f32.low, -3e38F);
    EXPECT_EQ(f32.high, 1e-40F);
}

TEST(RawRange, LeavesOutWhatIsNotFinite)
{
    constexpr float inf = std::numeric_limits<float>::infinity();
    for (const int side : {1, 50}) { // rests of vectors, and whole vectors
        ScalarGrid grid(VoxelType::f32, {2, side, 3}, Affine3d{});
        const float pattern[] = {-inf, inf, std::numeric_limits<float>::quiet_NaN(), -5.0F, -4.0F, inf};
        const std::size_t count = grid.voxel_count();
        for (std::size_t i = 0; i < count; ++i)
            grid.voxels<float>()[i] = pattern[i % 6];
        EXPECT_EQ(raw_range(grid).low, -5.0F);
        EXPECT_EQ(raw_range(grid).high, -4.0F);
        std::fill_n(grid.voxels<float>(), count, inf);
        EXPECT_TRUE(raw_range(grid).empty());
        std::fill_n(grid.voxels<float>(), count, std::numeric_limits<float>::quiet_NaN());
        EXPECT_TRUE(raw_range(grid).empty());
    }
    EXPECT_TRUE(raw_range(ScalarGrid{}).empty());
}

} // namespace
} // namespace lumisweep
