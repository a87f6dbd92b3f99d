// The generated shells, and the scenes that the studies measure.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>

#include "lumisweep/scene/load_scene.h"
#include "lumisweep/scene/scene_file.h"
#include "references.h"
#include "scenes.h"
#include "volumes.h"

namespace lumisweep::bench {
namespace {

/// By small steps along x through (j, k), outside of the program's own tracking.
double optical_depth_along_x(const Specimen& specimen, double y, double z)
{
    const ScalarGrid& volume = specimen.volume;
    const double voxel_world = length(volume.world_from_voxel().column[0]), step = 0.25;
    double sum = 0.0;
    for (double x = 0.5 * step; x < volume.size().x; x += step)
        sum += specimen.transfer_function.evaluate(volume.interpolate({x, y, z})).extinction;
    return sum * step * voxel_world;
}

TEST(FractalShells, AreThinAndOfTheGivenOpticalDepth)
{
    const Vec3i size{384, 384, 384};
    const Specimen specimen = fractal_shells(size, 2.0);
    std::size_t empty = 0;
    const auto* voxels = specimen.volume.voxels<std::uint8_t>();
    for (std::size_t i = 0; i < specimen.volume.voxel_count(); ++i)
        empty += voxels[i] == 0 ? 1 : 0;
    EXPECT_NEAR(static_cast<double>(empty) / static_cast<double>(specimen.volume.voxel_count()), 0.95, 0.015);

    std::mt19937_64 random(3);
    std::vector<double> depths;
    while (depths.size() < 2000) {
        const double y = static_cast<double>(random() % 384) + 0.5, z = static_cast<double>(random() % 384) + 0.5;
        const double depth = optical_depth_along_x(specimen, y, z);
        if (depth > 0.0)
            depths.push_back(depth);
    }
    const MeanAndError mean = mean_and_error(depths);
    EXPECT_LT(mean.error, 0.04);
    EXPECT_NEAR(mean.mean, 2.0, 4.0 * mean.error);
}

TEST(FractalShells, AreFractal)
{
    // Twice the voxels a side show more than four times the surface: voxels that are empty next to one that is not.
    const auto surface = [](int side) {
        const Specimen specimen = fractal_shells({side, side, side}, 2.0);
        const auto* v = specimen.volume.voxels<std::uint8_t>();
        const auto n = static_cast<std::size_t>(side);
        std::size_t count = 0;
        for (std::size_t i = 0; i + 1 < n * n * n; ++i)
            count += (v[i] == 0) != (v[i + 1] == 0) ? 1 : 0;
        return static_cast<double>(count);
    };
    EXPECT_GT(surface(256) / surface(128), 4.2);
}

TEST(BenchScenes, WrittenOnesAreTheLoadedOnes)
{
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "lumisweep-bench-scenes";
    std::filesystem::create_directories(folder);
    const SceneSources sources{LUMISWEEP_PROJECT, folder}; // no data are there
    for (const std::string name : {"plume", "ct_like", "shells_400"}) {
        ASSERT_TRUE(write_bench_scene(name, sources, SceneScale::quick, folder));
        const SessionInput read = load_scene(read_scene_file(folder / (name + ".json"))).input;
        const std::optional<SessionInput> made = load_bench_scene(name, sources, SceneScale::quick, {32, 32, false});
        ASSERT_TRUE(made);
        ASSERT_EQ(read.volume->size(), made->volume->size());
        EXPECT_EQ(std::memcmp(read.volume->data(), made->volume->data(), made->volume->bytes()), 0);
        const Vec3d corner = read.volume->world_from_voxel().offset - made->volume->world_from_voxel().offset;
        EXPECT_LT(length(corner), 1e-9);
        EXPECT_LT(length(read.camera.position - made->camera.position), 1e-9);
        EXPECT_DOUBLE_EQ(read.camera.vertical_fov_deg, made->camera.vertical_fov_deg);
        for (const double value : {20.0, 120.0, 600.0})
            EXPECT_DOUBLE_EQ(read.transfer_function.evaluate(value).extinction,
                             made->transfer_function.evaluate(value).extinction);
    }
    EXPECT_FALSE(write_bench_scene("ct_head", sources, SceneScale::quick, folder));
    EXPECT_FALSE(load_bench_scene("ct_head", sources, SceneScale::quick, {32, 32, false}));
    std::filesystem::remove_all(folder);
}

} // namespace
} // namespace lumisweep::bench
