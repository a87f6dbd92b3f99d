// A grid that is read while it is swept: whole directions only, the same bits as a sweep all at once, quickly
// cancelled.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <ctime>
#include <numeric>
#include <random>
#include <thread>
#include <vector>

#include <pthread.h>

#include "lumisweep/base/error.h"
#include "lumisweep/visibility/live_sweep.h"
#include "support/effort.h"
#include "visibility/generated_volumes.h"

namespace lumisweep {
namespace {

bool all_are(const VisibilityGrid& grid, int d, int value)
{
    const std::uint8_t* v = grid.direction(d);
    return std::all_of(v, v + grid.cell_count(), [&](std::uint8_t x) { return x == value; });
}

void fill(VisibilityGrid& grid, int d, int value) { std::memset(grid.direction(d), value, grid.cell_count()); }

TEST(LiveVisibilityTest, PublishesWhatIsStagedAndNothingElse)
{
    LiveVisibility live(VisibilityGrid({20, 16, 12}, 4, 4), 5);
    EXPECT_EQ(live.bytes(), VisibilityGrid::bytes_needed(5 * 4 * 3, 4)) << "spare slots are taken when they are needed";
    const int first[] = {3, 7, 11};
    VisibilityGrid& staged = live.stage(first);
    EXPECT_EQ(live.bytes(), VisibilityGrid::bytes_needed(5 * 4 * 3, 4) / 16 * 21);
    for (const int d : first)
        fill(staged, d, d);
    live.read([&](const VisibilityGrid& grid) {
        for (int d = 0; d < 16; ++d)
            EXPECT_TRUE(all_are(grid, d, 255));
    });
    live.publish();
    EXPECT_EQ(live.published(), 3U);
    const int second[] = {0, 1, 2, 3, 4};
    VisibilityGrid& abandoned = live.stage(second);
    for (const int d : second)
        fill(abandoned, d, 99);
    const int third[] = {1, 3};
    VisibilityGrid& again = live.stage(third);
    for (const int d : third)
        fill(again, d, 100 + d);
    live.publish();
    live.read([&](const VisibilityGrid& grid) {
        for (int d = 0; d < 16; ++d)
            EXPECT_TRUE(all_are(grid, d, d == 1 || d == 3 ? 100 + d : d == 7 || d == 11 ? d : 255)) << d;
    });
    EXPECT_EQ(live.settled().direction(7), live.last_read().direction(7));
}

TEST(LiveVisibilityTest, SpareSlotsAreFewButEnough)
{
    EXPECT_EQ(LiveVisibility::spare_slots(1, 4), 1);
    EXPECT_EQ(LiveVisibility::spare_slots(4, 4), 16);
    EXPECT_EQ(LiveVisibility::spare_slots(8, 1), 24);
    EXPECT_EQ(LiveVisibility::spare_slots(8, 64), 32);
    EXPECT_EQ(LiveVisibility::spare_slots(32, 8), 96);
}

// The writer gives every direction the number of its round, over and over; a reader that met a slot being written would
// find two numbers in it, or an older number than before.
TEST(LiveVisibilityConcurrency, ReadersMeetWholeDirections)
{
    const int reads = test::effort(250);
    for (const int spare : {1, 5, 16}) {
        LiveVisibility live(VisibilityGrid({256, 128, 4}, 4, 4), spare);
        const std::size_t numbers = live.last_read().cell_count() / sizeof(std::uint32_t);
        for (int d = 0; d < 16; ++d)
            fill(live.settled(), d, 0);
        std::atomic<bool> enough = false;
        std::uint32_t round = 0;
        std::thread writer([&] {
            std::mt19937 random(9);
            std::vector<int> order(16);
            std::iota(order.begin(), order.end(), 0);
            while (!enough) {
                ++round;
                std::shuffle(order.begin(), order.end(), random);
                for (int begin = 0; begin < 16; begin += spare) {
                    const std::span<const int> some = std::span(order).subspan(
                        static_cast<std::size_t>(begin), static_cast<std::size_t>(std::min(spare, 16 - begin)));
                    VisibilityGrid& staged = live.stage(some);
                    for (const int d : some)
                        for (std::size_t i = 0; i < numbers; ++i)
                            std::memcpy(staged.direction(d) + i * sizeof round, &round, sizeof round);
                    live.publish();
                }
            }
        });
        std::uint32_t seen[16] = {};
        int torn = 0, backwards = 0;
        const auto read = [&](const VisibilityGrid& grid) {
            for (int d = 0; d < 16; ++d) {
                std::this_thread::yield(); // the longer a read takes, the more it would meet
                std::vector<std::uint32_t> found(numbers);
                std::memcpy(found.data(), grid.direction(d), numbers * sizeof(std::uint32_t));
                torn +=
                    std::count(found.begin(), found.end(), found[0]) == static_cast<std::ptrdiff_t>(numbers) ? 0 : 1;
                backwards += found[0] < seen[d] ? 1 : 0;
                seen[d] = found[0];
            }
        };
        while (live.published() == 0)
            std::this_thread::yield();
        for (int i = 0; i < reads; ++i)
            live.read(read);
        enough = true;
        writer.join();
        live.read(read);
        EXPECT_EQ(torn, 0);
        EXPECT_EQ(backwards, 0);
        for (const std::uint32_t number : seen)
            EXPECT_EQ(number, round);
        EXPECT_EQ(live.published(), std::uint64_t{16} * round);
    }
}

LiveSweepInput ct_input(Vec3i size, int directions, int threads)
{
    LiveSweepInput input;
    input.volume = std::make_shared<ScalarGrid>(test::ct_volume(size, test::oblique()));
    input.range = raw_range(*input.volume);
    input.transfer_function = test::bone();
    input.visibility.directions = directions;
    input.threads = threads;
    return input;
}

TEST(LiveVisibilityConcurrency, SweepsGiveTheBitsOfOneSweep)
{
    for (const int directions : {1, 2, 8, 16})
        for (const int threads : {1, 2, 5}) {
            const LiveSweepInput input = ct_input({30, 26, 28}, directions, threads);
            VisibilityGrid expected(input.volume->size(), input.visibility.cell, directions);
            sweep_visibility(expected,
                             classify(*input.volume, input.range, input.transfer_function,
                                      sweep_mip_level(input.volume->size(), input.visibility.rays)),
                             input.visibility);
            LiveVisibility live(VisibilityGrid(input.volume->size(), input.visibility.cell, directions),
                                LiveVisibility::spare_slots(directions, threads));
            LiveSweepStats stats;
            EXPECT_TRUE(sweep_live(live, input, std::atomic<bool>(false), stats));
            EXPECT_EQ(live.published(), static_cast<std::uint64_t>(directions * directions));
            EXPECT_GT(stats.sweep.voxel_steps, 0U);
            EXPECT_GT(stats.sweep.bytes_read, 0U);
            for (int d = 0; d < directions * directions; ++d)
                EXPECT_EQ(std::memcmp(live.settled().direction(d), expected.direction(d), expected.cell_count()), 0)
                    << "direction " << d << " of " << directions << "², " << threads << " threads";
        }
}

TEST(LiveVisibilityConcurrency, SweepsSomeDirectionsAlone)
{
    LiveSweepInput input = ct_input({30, 26, 28}, 8, 1);
    VisibilityGrid expected(input.volume->size(), input.visibility.cell, 8);
    input.directions = {5, 58, 12, 33, 20, 5};
    sweep_visibility(expected, classify(*input.volume, input.range, input.transfer_function, 0), input.visibility,
                     input.directions);
    LiveVisibility live(VisibilityGrid(input.volume->size(), input.visibility.cell, 8), 24);
    LiveSweepStats stats;
    EXPECT_TRUE(sweep_live(live, input, std::atomic<bool>(false), stats));
    EXPECT_EQ(live.published(), 5U);
    for (int d = 0; d < 64; ++d)
        EXPECT_EQ(std::memcmp(live.settled().direction(d), expected.direction(d), expected.cell_count()), 0) << d;
}

TEST(LiveVisibilityConcurrency, RefusesAGridOfAnotherShape)
{
    const LiveSweepInput input = ct_input({30, 26, 28}, 8, 1);
    LiveVisibility live(VisibilityGrid({30, 26, 40}, input.visibility.cell, 8), 24);
    LiveSweepStats stats;
    EXPECT_THROW(sweep_live(live, input, std::atomic<bool>(false), stats), Error);
    EXPECT_EQ(live.published(), 0U);
}

double seconds_of(clockid_t clock)
{
    std::timespec t{};
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// From the flag to the return, at moments spread over classification and sweeps; in the sweeping thread's processor
// time, which other programs lengthen less. The system's part in it, for memory that is touched first, may be long now
// and then; a sweep that looks too rarely is late more often.
TEST(LiveVisibilityConcurrency, CancelsWithin20Milliseconds)
{
    const int side = test::full_effort ? 256 : 96;
    LiveSweepInput input = ct_input({side, side, side}, 8, 1);
    input.visibility.cell = 2;
    LiveVisibility live(VisibilityGrid(input.volume->size(), input.visibility.cell, 8), 24);
    std::vector<double> waits_s;
    for (int i = 0; i < 15; ++i) {
        std::atomic<bool> cancel = false, started = false, measured = false;
        double end_s = 0.0;
        bool complete = true;
        LiveSweepStats stats;
        std::thread sweeper([&] {
            started = true;
            complete = sweep_live(live, input, cancel, stats);
            end_s = seconds_of(CLOCK_THREAD_CPUTIME_ID);
            while (!measured)
                std::this_thread::yield();
        });
        while (!started)
            std::this_thread::yield();
        std::this_thread::sleep_for(std::chrono::milliseconds(5 * i));
        clockid_t clock{};
        ASSERT_EQ(pthread_getcpuclockid(sweeper.native_handle(), &clock), 0);
        const double asked_s = seconds_of(clock);
        cancel = true;
        measured = true;
        sweeper.join();
        if (!complete)
            waits_s.push_back(end_s - asked_s);
    }
    ASSERT_GE(waits_s.size(), 5U);
    std::sort(waits_s.begin(), waits_s.end());
    if (test::full_effort) {
        EXPECT_LT(waits_s[waits_s.size() * 3 / 4], 0.020) << "the latest: " << waits_s.back();
    }
}

} // namespace
} // namespace lumisweep
