// Sweeps on the device against the CPU's, byte by byte.
#include "lumisweep/backends/cuda/device_sweep.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "backends/device_volumes.h"
#include "backends/emulated_device.h"
#include "lumisweep/base/error.h"
#include "lumisweep/visibility/sweep.h"
#include "visibility/generated_volumes.h"
#include "visibility/sweep_case.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

using namespace lumisweep::test;

class DeviceSweeps : public ::testing::Test {
protected:
    static constexpr std::uint64_t all_memory = std::uint64_t{1} << 40;
    ~DeviceSweeps() override { set_emulated_memory(all_memory); }

    static VisibilityGrid empty_grid(const ExtinctionGrid& extinction, const VisibilitySettings& settings)
    {
        return VisibilityGrid(extinction.volume_size, settings.cell, settings.directions);
    }
    VisibilityGrid swept(const ExtinctionGrid& extinction, const VisibilitySettings& settings)
    {
        const DeviceExtinction voxels = on_device(extinction, stream);
        DeviceVisibility visibility;
        VisibilityGrid grid = empty_grid(extinction, settings);
        visibility.resize(grid.cells(), settings.directions);
        EXPECT_TRUE(sweep.sweep(visibility, voxels, settings, stream));
        visibility.download(grid, stream);
        return grid;
    }
    /// Compares all directions.
    void expect_equal(const ExtinctionGrid& extinction, const VisibilitySettings& settings)
    {
        VisibilityGrid expected = empty_grid(extinction, settings);
        const SweepStats stats = sweep_visibility(expected, extinction, settings);
        const VisibilityGrid found = swept(extinction, settings);
        EXPECT_EQ(sweep.voxel_steps(), stats.voxel_steps);
        for (int d = 0; d < expected.direction_count(); ++d) {
            const std::uint8_t *a = expected.direction(d), *b = found.direction(d);
            const std::uint8_t* differs = std::mismatch(a, a + expected.cell_count(), b).first;
            ASSERT_EQ(differs - a, static_cast<std::ptrdiff_t>(expected.cell_count()))
                << "direction " << d << ", first of the cells that differ";
        }
    }

    const Stream stream;
    DeviceSweep sweep;
};

/// Noise with some depth to it.
ExtinctionGrid noise(Vec3i size, const Affine3d& world_from_voxel = {})
{
    ExtinctionGrid grid;
    grid.volume_size = grid.size = size;
    grid.world_from_voxel = world_from_voxel;
    std::mt19937 random(static_cast<std::uint32_t>(size.x + 1000 * size.y + 1000000 * size.z));
    store_voxels(grid, FilledIn::voxels, [&](int, int, int) { return random() % 4 == 0 ? random() % 256 : 0; });
    grid.scale = 3.0F / (32.0F * static_cast<float>(std::max({size.x, size.y, size.z})));
    return grid;
}

VisibilitySettings settings_of(int directions, int cell, SweepFilter filter = SweepFilter::half_angle,
                               int oversampling = 1)
{
    VisibilitySettings settings;
    settings.rays = 8192;
    settings.directions = directions;
    settings.cell = cell;
    settings.filter = filter;
    settings.oversampling = oversampling;
    return settings;
}

// Odd sizes, all shapes of voxels, mip levels, cells, directions, filters and oversampling, side by side and one after
// the other with one DeviceSweep.
TEST_F(DeviceSweeps, EqualTheCpusOnAllKindsOfVolumes)
{
    for (std::uint32_t number = 1; number <= 100 && !HasFatalFailure(); ++number) {
        SweepCase c(number);
        SCOPED_TRACE(::testing::Message() << c);
        expect_equal(c.extinction, c.settings);
    }
}

TEST_F(DeviceSweeps, AnyCell)
{
    for (int cell = 1; cell <= 8 && !HasFatalFailure(); ++cell) {
        SCOPED_TRACE(cell);
        expect_equal(noise({24, 32, 40}), settings_of(4, cell));
        expect_equal(noise({25, 19, 13}, oblique()), settings_of(4, cell));
    }
}

TEST_F(DeviceSweeps, AnyFilterAndDirections)
{
    for (const int directions : {1, 2, 4, 8, 16})
        for (const SweepFilter filter : {SweepFilter::none, SweepFilter::half_angle, SweepFilter::full_angle}) {
            SCOPED_TRACE(::testing::Message() << directions << ", " << static_cast<int>(filter));
            expect_equal(noise({33, 21, 27}, spaced({1.0, 0.7, 1.9})), settings_of(directions, 2, filter));
            if (HasFatalFailure())
                return;
        }
}

// Several tiles of rays along both axes of each plane, and boxes so wide that V is shifted down.
TEST_F(DeviceSweeps, LargerThanATile)
{
    const ScalarGrid volume = ct_volume({150, 70, 90}, spaced({0.8, 1.0, 0.9}));
    const ExtinctionGrid extinction = classified(volume, bone());
    expect_equal(extinction, settings_of(4, 4));
    expect_equal(extinction, settings_of(4, 2, SweepFilter::full_angle));
    expect_equal(noise({300, 9, 7}), settings_of(4, 1, SweepFilter::full_angle));
    expect_equal(noise({7, 300, 9}), settings_of(2, 1, SweepFilter::full_angle));
    expect_equal(noise({9, 7, 300}), settings_of(2, 1, SweepFilter::full_angle));
}

TEST_F(DeviceSweeps, BoxesOfManyCells)
{
    for (const int side : {40, 150, 600}) {
        ExtinctionGrid extinction = noise({side, 2, 2});
        for (const float scale : {1e-9F, 1e-3F, 1e30F}) {
            extinction.scale = scale;
            expect_equal(extinction, settings_of(1, 1, SweepFilter::full_angle));
        }
    }
}

TEST_F(DeviceSweeps, LinesOfATexelAreAveraged)
{
    for (const int oversampling : {4, 16})
        for (const int directions : {1, 4}) {
            expect_equal(noise({23, 30, 17}), settings_of(directions, 3, SweepFilter::none, oversampling));
            expect_equal(noise({16, 16, 16}, oblique()),
                         settings_of(directions, 4, SweepFilter::half_angle, oversampling));
        }
}

TEST_F(DeviceSweeps, OneVoxelThin)
{
    for (const Vec3i& size : {Vec3i{1, 40, 30}, Vec3i{40, 1, 30}, Vec3i{40, 30, 1}, Vec3i{1, 1, 50}, Vec3i{1, 1, 1}})
        for (const int cell : {1, 4})
            expect_equal(noise(size), settings_of(8, cell));
}

TEST_F(DeviceSweeps, OfMipLevels)
{
    const ScalarGrid volume = smoke_volume({61, 50, 71}, oblique());
    for (const int rays : {40, 20, 9}) {
        VisibilitySettings settings = settings_of(4, 3);
        settings.rays = rays;
        const int level = sweep_mip_level(volume.size(), rays);
        ASSERT_GT(level, 0);
        expect_equal(classified(volume, smoke(), level), settings);
    }
}

TEST_F(DeviceSweeps, NothingToSee)
{
    ExtinctionGrid empty = noise({20, 20, 20});
    empty.scale = 0.0F;
    const VisibilityGrid grid = swept(empty, settings_of(4, 4));
    for (int d = 0; d < grid.direction_count(); ++d)
        for (std::size_t i = 0; i < grid.cell_count(); ++i)
            ASSERT_EQ(grid.direction(d)[i], 255);
}

// With little memory lines come in batches, at the end one by one; a texel's lines may be of several.
TEST_F(DeviceSweeps, InBatches)
{
    const ExtinctionGrid extinction = noise({30, 26, 34});
    for (const int oversampling : {1, 4, 16}) {
        const VisibilitySettings settings = settings_of(4, 2, SweepFilter::half_angle, oversampling);
        for (const std::uint64_t kilobytes : {8000U, 3000U, 1500U, 900U, 500U}) {
            SCOPED_TRACE(kilobytes);
            sweep.~DeviceSweep();
            new (&sweep) DeviceSweep();
            set_emulated_memory(emulated_memory_taken() + 1024 * kilobytes);
            expect_equal(extinction, settings);
            set_emulated_memory(all_memory);
        }
    }
}

TEST_F(DeviceSweeps, UploadOnlyWhatIsNew)
{
    const VisibilitySettings settings = settings_of(4, 4);
    ExtinctionGrid extinction = noise({40, 30, 20});
    expect_equal(extinction, settings);
    const DeviceExtinction voxels = on_device(extinction, stream);
    DeviceVisibility visibility;
    visibility.resize(VisibilityGrid::cells_of(extinction.volume_size, settings.cell), settings.directions);
    const std::uint64_t before = bytes_uploaded(), taken = emulated_memory_taken();
    EXPECT_TRUE(sweep.sweep(visibility, voxels, settings, stream));
    EXPECT_EQ(bytes_uploaded(), before);
    EXPECT_EQ(emulated_memory_taken(), taken);

    extinction.scale *= 2.0F; // the same plan
    expect_equal(extinction, settings);
    extinction.world_from_voxel = oblique(); // others
    expect_equal(extinction, settings);
    expect_equal(extinction, settings_of(4, 5));
}

TEST_F(DeviceSweeps, CanBeCancelled)
{
    const ExtinctionGrid extinction = noise({60, 60, 60});
    const VisibilitySettings settings = settings_of(8, 2);
    const DeviceExtinction voxels = on_device(extinction, stream);
    DeviceVisibility visibility;
    VisibilityGrid expected = empty_grid(extinction, settings), found = empty_grid(extinction, settings);
    sweep_visibility(expected, extinction, settings);
    visibility.resize(expected.cells(), settings.directions);
    fill_on_device(visibility.stored.data(), 7, visibility.stored.bytes(), stream);

    std::atomic<bool> cancel = true;
    EXPECT_FALSE(sweep.sweep(visibility, voxels, settings, stream, &cancel));
    visibility.download(found, stream);
    EXPECT_EQ(found.direction(0)[0], 7);

    set_emulated_memory(emulated_memory_taken() + (std::uint64_t{8} << 20)); // several batches
    // Sooner and sooner, until it comes before the end, however fast the machine.
    bool ended = true;
    for (std::chrono::microseconds delay{32000}; ended; delay /= 2) {
        fill_on_device(visibility.stored.data(), 7, visibility.stored.bytes(), stream);
        cancel = false;
        std::thread thread([&] {
            std::this_thread::sleep_for(delay);
            cancel = true;
        });
        ended = sweep.sweep(visibility, voxels, settings, stream, &cancel);
        thread.join();
        visibility.download(found, stream);
        for (int d = 0; d < found.direction_count(); ++d) {
            const std::uint8_t* v = found.direction(d);
            const bool old = std::all_of(v, v + found.cell_count(), [](std::uint8_t byte) { return byte == 7; });
            EXPECT_TRUE((old && !ended) || std::memcmp(v, expected.direction(d), found.cell_count()) == 0);
        }
    }
    cancel = false;
    EXPECT_TRUE(sweep.sweep(visibility, voxels, settings, stream, &cancel));
}

TEST_F(DeviceSweeps, RefuseWhatDoesNotFit)
{
    const ExtinctionGrid extinction = noise({20, 20, 20});
    const DeviceExtinction voxels = on_device(extinction, stream);
    DeviceVisibility visibility;
    visibility.resize({5, 5, 5}, 4);
    EXPECT_THROW(sweep.sweep(visibility, voxels, settings_of(4, 5), stream), Error);
    EXPECT_THROW(sweep.sweep(visibility, voxels, settings_of(8, 4), stream), Error);
    VisibilitySettings coarser = settings_of(4, 4);
    coarser.rays = 10;
    EXPECT_THROW(sweep.sweep(visibility, voxels, coarser, stream), Error);
}

} // namespace
} // namespace lumisweep::LUMISWEEP_CUDA
