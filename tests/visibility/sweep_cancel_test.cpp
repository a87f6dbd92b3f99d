// How soon a sweep ends when it is told to, and what memory it takes meanwhile.
#include <gtest/gtest.h>

#include <malloc.h>
#include <pthread.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <thread>
#include <vector>

#include <tbb/task_arena.h>

#include "lumisweep/visibility/sweep.h"
#include "lumisweep/visibility/sweep_memory.h"
#include "stored_voxels.h"
#include "support/effort.h"

namespace lumisweep {
namespace {

using namespace test;

#if defined(__SANITIZE_ADDRESS__)
constexpr bool measurable = false; // sanitizers take time and memory of their own
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
constexpr bool measurable = false;
#else
constexpr bool measurable = full_effort;
#endif
#else
constexpr bool measurable = full_effort;
#endif

double seconds(clockid_t clock)
{
    timespec t{};
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

ExtinctionGrid large_volume(Vec3i size)
{
    ExtinctionGrid grid;
    grid.volume_size = grid.size = size;
    grid.scale = 1e-4F;
    store_voxels(grid, FilledIn::lines, [](int i, int j, int k) { return (i ^ j ^ k) & 255; });
    return grid;
}

/// Processor time that a sweep on one thread takes after it was cancelled when it had used `after_s`; −1 if it had
/// ended by then. Not elapsed time: the machine may have other things to do.
double latency_s(const ExtinctionGrid& volume, const VisibilitySettings& settings, double after_s)
{
    VisibilityGrid grid(volume.volume_size, settings.cell, settings.directions);
    std::atomic<bool> cancel{false}, done{false};
    double end = 0.0;
    std::thread sweeping([&] {
        tbb::task_arena(1).execute([&] { sweep_visibility(grid, volume, settings, {}, &cancel); });
        end = seconds(CLOCK_THREAD_CPUTIME_ID);
        done = true;
        while (!cancel)
            std::this_thread::sleep_for(std::chrono::microseconds(100));
    });
    clockid_t clock{};
    pthread_getcpuclockid(sweeping.native_handle(), &clock);
    while (!done && seconds(clock) < after_s)
        std::this_thread::sleep_for(std::chrono::microseconds(100));
    const bool in_time = !done;
    cancel = true;
    const double told = seconds(clock);
    sweeping.join();
    return in_time ? std::max(end - told, 0.0) : -1.0;
}

TEST(SweepCancel, ReturnsWithin20Milliseconds)
{
    if (!measurable)
        GTEST_SKIP();
    const ExtinctionGrid volume = large_volume({256, 256, 192});
    const auto worst = [&](int cell, int oversampling) {
        VisibilitySettings settings;
        settings.cell = cell;
        settings.oversampling = oversampling;
        settings.rays = 256;
        double latency = 0.0;
        for (const double after_s : {0.001, 0.008, 0.03}) {
            double least = 1e30; // other load on the machine only ever adds
            for (int attempt = 0; attempt < 5 && !(least < 0.02); ++attempt)
                least = std::min(least, latency_s(volume, settings, after_s));
            latency = std::max(latency, least);
        }
        return latency;
    };
    EXPECT_LT(worst(4, 1), 0.02);
    EXPECT_LT(worst(4, 16), 0.02);
    EXPECT_LT(worst(1, 1), 0.02);
    EXPECT_LT(worst(2, 4), 0.02);
}

/// Memory that the process has touched and not given back.
std::uint64_t resident_bytes()
{
    std::ifstream statm("/proc/self/statm");
    std::uint64_t size = 0, resident = 0;
    statm >> size >> resident;
    return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

TEST(SweepMemory, StaysWithinTheEstimate)
{
    if (!measurable)
        GTEST_SKIP();
    for (const Vec3i size : {Vec3i{120, 100, 110}, Vec3i{150, 30, 200}})
        for (const int cell : {1, 4})
            for (const int oversampling : {1, 16}) {
                const ExtinctionGrid volume = large_volume(size);
                VisibilitySettings settings;
                settings.cell = cell;
                settings.oversampling = oversampling;
                settings.directions = oversampling == 1 ? 4 : 2;
                settings.rays = 8192;
                VisibilityGrid grid(size, cell, settings.directions);
                malloc_trim(0); // so that nothing freed before is taken again unseen
                const std::uint64_t before = resident_bytes();
                std::uint64_t most = before;
                std::atomic<bool> done{false};
                std::thread watching([&] {
                    for (; !done; std::this_thread::sleep_for(std::chrono::microseconds(200)))
                        most = std::max(most, resident_bytes());
                });
                tbb::task_arena(1).execute([&] { sweep_visibility(grid, volume, settings); });
                done = true;
                watching.join();
                const std::uint64_t small_things = std::uint64_t{1} << 20;
                EXPECT_LE(most - before, sweep_scratch_bytes(size, settings, 1) + small_things)
                    << size.x << " x " << size.y << " x " << size.z << ", cell " << cell << ", oversampling "
                    << oversampling;
            }
}

} // namespace
} // namespace lumisweep
