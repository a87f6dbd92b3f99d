// Presets: valid for any data, chosen for a reason, and framed by a camera that sees the content.
#include "lumisweep/scene/presets.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lumisweep/base/error.h"
#include "lumisweep/scene/framing.h"

namespace lumisweep {
namespace {

ScalarGrid grid_of(VoxelType type, Vec3i size) { return ScalarGrid(type, size, Affine3d{}); }

/// i16 voxels in four parts of the given shares.
ValueStatistics mixture(std::initializer_list<std::pair<double, int>> shares)
{
    ScalarGrid grid = grid_of(VoxelType::i16, {100, 100, 1});
    std::size_t at = 0;
    for (const auto& [share, value] : shares)
        for (int i = 0; i < static_cast<int>(share * 10000) && at < 10000; ++i)
            grid.voxels<std::int16_t>()[at++] = static_cast<std::int16_t>(value);
    return value_statistics(grid);
}

TEST(ValueStatistics, CountsRangeAndPercentilesExactlyForShortRanges)
{
    ScalarGrid grid = grid_of(VoxelType::u8, {256, 4, 4});
    for (std::size_t i = 0; i < grid.voxel_count(); ++i)
        grid.voxels<std::uint8_t>()[i] = static_cast<std::uint8_t>(i % 256);
    const ValueStatistics values = value_statistics(grid);
    EXPECT_EQ(values.min, 0.0);
    EXPECT_EQ(values.max, 255.0);
    EXPECT_EQ(values.histogram.size(), 256U);
    for (const std::uint64_t count : values.histogram)
        EXPECT_EQ(count, 16U);
    EXPECT_EQ(values.percentile(0.5), 127.0);
    EXPECT_EQ(values.percentile(1.0), 255.0);
}

TEST(ValueStatistics, LeavesOutNonFiniteVoxelsAndHonoursANegativeSlope)
{
    ScalarGrid grid(VoxelType::f32, {4, 1, 1}, Affine3d{}, -2.0, 1.0);
    float* v = grid.voxels<float>();
    v[0] = 0.0F, v[1] = 1.0F, v[2] = std::numeric_limits<float>::quiet_NaN(), v[3] = 1.0F;
    const ValueStatistics values = value_statistics(grid, 10);
    EXPECT_EQ(values.non_finite, 1U);
    EXPECT_EQ(values.min, -1.0);
    EXPECT_EQ(values.max, 1.0);
    EXPECT_EQ(values.histogram.front(), 2U); // −1 twice
    EXPECT_EQ(values.histogram.back(), 1U);
}

TEST(Presets, AreValidTransferFunctionsForAnyData)
{
    const ScalarGrid constant = grid_of(VoxelType::u16, {3, 3, 3});
    ScalarGrid empty = grid_of(VoxelType::f32, {2, 2, 2});
    for (std::size_t i = 0; i < 8; ++i)
        empty.voxels<float>()[i] = std::numeric_limits<float>::quiet_NaN();
    for (const ValueStatistics& values :
         {value_statistics(constant), value_statistics(empty), mixture({{0.5, -1000}, {0.4, 50}, {0.1, 1200}})})
        for (const std::string_view name : preset_names()) {
            PresetInput input;
            input.values = values;
            const TransferFunction transfer_function(preset_points(name, input)); // throws when invalid
            double largest = 0.0;
            for (const TransferPoint& point : transfer_function.points())
                largest = std::max(largest, point.extinction);
            EXPECT_GT(largest, 0.0) << name;
        }
    EXPECT_THROW(preset_points("bone", PresetInput{}), Error);
}

TEST(Presets, BoneIsOpaqueWithinAMillimetreAndSoftTissueLetsLightIn)
{
    const TransferFunction bone(preset_points("ct-bone", {}));
    EXPECT_GE(bone.evaluate(500).extinction, 2.0);
    EXPECT_EQ(bone.evaluate(60).extinction, 0.0);
    const TransferFunction tissue(preset_points("ct-soft-tissue", {}));
    EXPECT_GT(tissue.evaluate(40).extinction, 0.05);
    EXPECT_LT(tissue.evaluate(40).extinction, 1.0);
}

TEST(Presets, ScaleWithTheVolumesSize)
{
    PresetInput small, large;
    small.values = large.values = mixture({{0.7, 0}, {0.3, 100}});
    small.diameter = 2.0;
    large.diameter = 200.0;
    for (const char* name : {"mr-default", "smoke"})
        EXPECT_NEAR(preset_points(name, small).back().extinction, 100.0 * preset_points(name, large).back().extinction,
                    1e-9);
}

PresetChoice choice(const std::string& modality, const ValueStatistics& values, int frames = 1)
{
    return choose_preset({modality, values, 200.0, frames});
}

TEST(Presets, AreChosenByModalityOrHistogramAndSaySo)
{
    const ValueStatistics head = mixture({{0.6, -1000}, {0.33, 40}, {0.07, 900}});
    EXPECT_EQ(choice("CT", head).name, "ct-bone");
    EXPECT_EQ(choice("CT", head).reason, "no preset named: took ct-bone because the modality is CT");
    EXPECT_EQ(choice("", head).name, "ct-bone");
    EXPECT_EQ(choice("MR", head).name, "mr-default");
    EXPECT_EQ(choice("", mixture({{0.75, 0}, {0.235, 100}, {0.013, 400}, {0.002, 1500}})).name, "ct-vessels-and-metal");
    EXPECT_EQ(choice("", mixture({{0.9, 0}, {0.1, 200}}), 40).name, "smoke");
    EXPECT_EQ(choice("", mixture({{0.9, 0}, {0.1, 200}})).name, "smoke");
    EXPECT_EQ(choice("", mixture({{0.4, 0}, {0.4, 80}, {0.2, 120}})).name, "mr-default");
    EXPECT_EQ(choice("CT", mixture({{0.6, -1000}, {0.4, 40}})).name, "ct-soft-tissue");
}

TEST(Presets, ShiftHounsfieldUnitsStoredWithAnOffset)
{
    const ValueStatistics shifted = mixture({{0.5, 24}, {0.43, 1070}, {0.07, 1924}});
    EXPECT_EQ(hounsfield_offset(shifted), 1024.0);
    PresetInput input;
    input.values = shifted;
    EXPECT_EQ(preset_points("ct-bone", input).front().value, preset_points("ct-bone", {}).front().value + 1024.0);
    EXPECT_EQ(hounsfield_offset(mixture({{0.75, 0}, {0.235, 100}, {0.015, 1500}})), 0.0);
}

TEST(Framing, FindsTheVisibleBoxDespiteStrayVoxels)
{
    ScalarGrid grid = grid_of(VoxelType::u8, {40, 40, 40});
    for (int k = 10; k < 30; ++k)
        for (int j = 12; j < 28; ++j)
            for (int i = 5; i < 20; ++i)
                grid.voxels<std::uint8_t>()[(k * 40 + j) * 40 + i] = 200;
    grid.voxels<std::uint8_t>()[0] = 200;
    const TransferFunction transfer_function({{100, 0.0, {1, 1, 1}}, {150, 1.0, {1, 1, 1}}});
    const VoxelBox box = visible_box(grid, transfer_function, value_statistics(grid));
    EXPECT_EQ(box.low, (Vec3d{5, 12, 10}));
    EXPECT_EQ(box.high, (Vec3d{20, 28, 30}));
}

TEST(Framing, SeesTheWholeBoxFromInFront)
{
    const ScalarGrid grid(VoxelType::u8, {20, 30, 40}, Affine3d{});
    const VoxelBox box{{0, 0, 0}, {20, 30, 40}};
    for (const ImageSettings& image : {ImageSettings{200, 100, true}, ImageSettings{100, 300, true}}) {
        const Camera camera = frame_camera({}, grid, box, image);
        EXPECT_EQ(camera.target, (Vec3d{10, 15, 20}));
        EXPECT_LT(camera.position.y, 0.0); // anterior in LPS
        EXPECT_GT(camera.position.z, 20.0);
        const std::array<double, 16> m = camera.camera_from_world();
        const double tan_half = std::tan(camera.vertical_fov_deg * 3.14159265358979 / 360.0);
        double largest = 0.0;
        for (int c = 0; c < 8; ++c) {
            const Vec3d p{(c & 1) * 20.0, (c >> 1 & 1) * 30.0, (c >> 2) * 40.0};
            const double x = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
                         y = m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7];
            const double depth = m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11];
            ASSERT_GT(depth, 0.0);
            largest = std::max({largest, std::abs(y) / (depth * tan_half),
                                std::abs(x) / (depth * tan_half * image.width / image.height)});
        }
        EXPECT_NEAR(largest, 0.92, 1e-9); // fits, and no farther away than that takes
    }
}

} // namespace
} // namespace lumisweep
