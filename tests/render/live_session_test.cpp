// Sessions whose sweeps run in the background: the same means while they run, the same bits when they are done; and
// what an edit redoes.
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <new>

#include <sys/resource.h>
#include <unistd.h>

#include "support/effort.h"
#include "support/films.h"
#include "support/scenes.h"

namespace lumisweep {
namespace {

SessionInput edited_scene(Vec3i size = {27, 30, 25})
{
    SessionInput input;
    input.volume = test::ct_like(size, test::centered(size, {1.0, 1.1, 0.9}));
    input.transfer_function = test::ct_transfer_function();
    input.environment = test::sky_with_sun(64, 12.0);
    input.image = {32, 32, false};
    input.camera.position = {25.0, -70.0, 20.0};
    input.camera.vertical_fov_deg = 22.0;
    return input;
}

/// One whose sweep takes seconds.
SessionInput slow_scene()
{
    const int side = test::full_effort ? 160 : 64;
    SessionInput input = edited_scene({side, side, side});
    input.visibility.directions = 32;
    input.visibility.oversampling = 4;
    input.visibility.cell = 8;
    return input;
}

::testing::AssertionResult same_visibility(const Session& a, const Session& b)
{
    if (!a.visibility().same_shape(b.visibility()))
        return ::testing::AssertionFailure() << "shapes differ";
    for (int d = 0; d < a.visibility().direction_count(); ++d)
        if (std::memcmp(a.visibility().direction(d), b.visibility().direction(d), a.visibility().cell_count()) != 0)
            return ::testing::AssertionFailure() << "direction " << d << " differs";
    return ::testing::AssertionSuccess();
}

TEST(SessionStages, LightingChangesRedoOnlyTheProduct)
{
    for (const SweepMode mode : {SweepMode::before_pass, SweepMode::in_background}) {
        SessionInput input = edited_scene();
        Session session(input, make_cpu_backend());
        session.set_sweep_mode(mode);
        const auto counts = [&](auto&& change) {
            session.prepare();
            const SessionStats before = session.stats();
            change();
            session.prepare();
            session.render_pass();
            const SessionStats& after = session.stats();
            return std::array<int, 3>{after.classifications - before.classifications, after.sweeps - before.sweeps,
                                      after.joint_builds - before.joint_builds};
        };
        using Counts = std::array<int, 3>; // classifications, sweeps, joint grids
        session.prepare();
        EXPECT_EQ(session.stats().sweeps, 1);
        EXPECT_EQ(counts([] {}), (Counts{0, 0, 0}));
        EXPECT_EQ(counts([&] { session.set_environment(test::constant_light()); }), (Counts{0, 0, 1}));
        EXPECT_EQ(counts([&] {
                      session.set_environment(test::one_texel_light(4, {1.0, 0.2, 0.4}, {3.0, 2.0, 1.0}));
                  }),
                  (Counts{0, 0, 1}));
        EXPECT_EQ(counts([&] { session.set_render({Strategy::visibility, 1}); }), (Counts{0, 0, 1}));
        EXPECT_EQ(counts([&] { session.set_render({Strategy::visibility, 2}); }), (Counts{0, 0, 0}));
        EXPECT_EQ(counts([&] { session.set_render({Strategy::environment, 2}); }), (Counts{0, 0, 0}));
        EXPECT_EQ(counts([&] { session.set_render({Strategy::two_step, 2}); }), (Counts{0, 0, 1}));
        input.visibility.epsilon = 0.03;
        EXPECT_EQ(counts([&] { session.set_visibility(input.visibility); }), (Counts{0, 0, 1}));
        EXPECT_EQ(counts([&] { session.set_camera(test::needle({0.0, -30.0, 0.0}, {})); }), (Counts{0, 0, 0}));
        EXPECT_EQ(counts([&] { session.set_image({20, 10, true}); }), (Counts{0, 0, 0}));
        const std::array<int, 3> edit = counts([&] { session.set_transfer_function(test::ct_transfer_function(0.5)); });
        EXPECT_EQ(edit[0], 1);
        EXPECT_EQ(edit[1], 1);
        EXPECT_GE(edit[2], 1);
        input.visibility.filter = SweepFilter::none;
        EXPECT_EQ(counts([&] { session.set_visibility(input.visibility); })[1], 1);
        input.visibility.cell = 5;
        EXPECT_EQ(counts([&] { session.set_visibility(input.visibility); })[1], 1);
        EXPECT_EQ(counts([&] { session.set_volume(edited_scene({20, 21, 22}).volume); })[1], 1);
    }
}

// Every setter while the sweeps of the one before may still run; prepare() gives what a fresh session has.
TEST(SessionConcurrency, PreparedAfterEditsItIsTheSynchronousOneToTheBit)
{
    SessionInput input = edited_scene();
    input.visibility.cell = 2;
    Session session(input, make_cpu_backend());
    session.set_sweep_mode(SweepMode::in_background, 2);
    const auto expect_same = [&](const char* what) {
        session.prepare();
        EXPECT_FALSE(session.sweeping());
        Session fresh(input, make_cpu_backend());
        fresh.prepare();
        EXPECT_TRUE(same_visibility(session, fresh)) << what;
        session.set_render(input.render); // clears the film
        for (int i = 0; i < 2; ++i) {
            session.render_pass();
            fresh.render_pass();
        }
        EXPECT_TRUE(test::same_film(session.film(), fresh.film())) << what;
    };
    expect_same("first sweep");
    for (const double scale : {0.5, 3.0, 0.1})
        session.set_transfer_function(input.transfer_function = test::ct_transfer_function(scale));
    expect_same("transfer functions");
    session.set_transfer_function(input.transfer_function = test::ct_transfer_function(2.0));
    session.render_pass();
    session.set_volume(input.volume = test::smoke_like(input.volume->size(), input.volume->world_from_voxel()));
    session.render_pass();
    expect_same("volume of the same shape");
    session.set_volume(input.volume = edited_scene({28, 30, 25}).volume);
    expect_same("volume of other voxels and as many cells");
    session.set_volume(input.volume = edited_scene({40, 21, 33}).volume);
    session.render_pass();
    input.visibility.directions = 16;
    session.set_visibility(input.visibility);
    session.render_pass();
    session.set_environment(input.environment = test::constant_light({0.3, 0.4, 0.2}));
    expect_same("another shape");
    input.visibility.rays = 16;
    session.set_visibility(input.visibility);
    session.render_pass();
    session.set_render(input.render = {Strategy::uniform, 5});
    session.set_transfer_function(input.transfer_function = test::ct_transfer_function(0.7));
    session.render_pass();
    session.set_render(input.render = {Strategy::combined, 6});
    session.render_pass();
    expect_same("strategies");
    session.set_transfer_function(input.transfer_function = test::ct_transfer_function(1.1));
    session.set_sweep_mode(SweepMode::before_pass);
    expect_same("back to sweeps before the pass");
    VisibilityGrid ones(input.volume->size(), input.visibility.cell, input.visibility.directions);
    session.set_sweep_mode(SweepMode::in_background);
    session.set_transfer_function(input.transfer_function);
    session.replace_visibility(std::move(ones));
    session.prepare();
    EXPECT_EQ(*std::min_element(session.visibility().direction(0),
                                session.visibility().direction(0) + session.visibility().cell_count()),
              255);
}

TEST(SessionConcurrency, EditsReturnAtOnceAndPassesGoOn)
{
    using Clock = std::chrono::steady_clock;
    const SessionInput input = slow_scene();
    std::vector<double> edit_s;
    Clock::time_point ending;
    {
        Session session(input, make_cpu_backend());
        session.set_sweep_mode(SweepMode::in_background, 1);
        EXPECT_EQ(session.render_pass(), PassEnd::complete);
        for (int i = 0; i < 5; ++i) {
            const Clock::time_point begin = Clock::now();
            session.set_transfer_function(test::ct_transfer_function(1.0 + i));
            edit_s.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
            EXPECT_EQ(session.film().samples(), 0);
            EXPECT_EQ(session.render_pass(), PassEnd::complete);
            EXPECT_EQ(session.render_pass(), PassEnd::complete);
            EXPECT_EQ(session.film().samples(), 2);
            EXPECT_TRUE(session.sweeping()) << "the sweep was too quick for this test";
        }
        const std::atomic<bool> impatient = true;
        session.prepare(&impatient);
        EXPECT_TRUE(session.sweeping());
        ending = Clock::now();
    }
    const double end_s = std::chrono::duration<double>(Clock::now() - ending).count();
    std::sort(edit_s.begin(), edit_s.end());
    if (test::full_effort) {
        EXPECT_LT(edit_s[2], 0.005);
        EXPECT_LT(end_s, 0.1); // the sweep is cancelled, not finished
    }
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(LUMISWEEP_TEST_SLOW)
/// Limits the address space to what is taken and `bytes` more, for as long as it lives.
class AddressSpaceLimit {
public:
    explicit AddressSpaceLimit(std::size_t bytes)
    {
        std::size_t pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        getrlimit(RLIMIT_AS, &before_);
        rlimit limit = before_;
        limit.rlim_cur = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + bytes;
        setrlimit(RLIMIT_AS, &limit);
    }
    ~AddressSpaceLimit() { setrlimit(RLIMIT_AS, &before_); }
    AddressSpaceLimit(const AddressSpaceLimit&) = delete;
    AddressSpaceLimit& operator=(const AddressSpaceLimit&) = delete;

private:
    rlimit before_{};
};

// A background sweep that finds no memory: the next pass says so, the session goes on, and the sweep is tried again.
TEST(SessionConcurrency, ErrorsReachTheNextPass)
{
    SessionInput input = edited_scene({320, 320, 320}); // 65 MB to classify
    input.visibility.rays = 512;
    input.visibility.cell = 16;
    Session session(input, make_cpu_backend());
    session.set_sweep_mode(SweepMode::in_background, 1);
    session.prepare();
    session.render_pass();
    {
        const AddressSpaceLimit limit(std::size_t{24} << 20);
        session.set_transfer_function(input.transfer_function = test::ct_transfer_function(0.5));
        const auto passes_until_it_fails = [&] {
            for (int pass = 0; pass < 1000; ++pass)
                session.render_pass();
        };
        EXPECT_THROW(passes_until_it_fails(), std::bad_alloc);
        EXPECT_FALSE(session.sweeping());
        EXPECT_EQ(session.render_pass(), PassEnd::complete);
        EXPECT_FALSE(session.sweeping());
        EXPECT_THROW(session.prepare(), std::bad_alloc);
    }
    session.prepare();
    Session fresh(input, make_cpu_backend());
    fresh.prepare();
    EXPECT_TRUE(same_visibility(session, fresh));
}
#endif

TEST(SessionConcurrency, DirectionsArriveWhilePassesGoOn)
{
    SessionInput input = slow_scene();
    input.visibility.directions = 16;
    Session session(input, make_cpu_backend());
    session.set_sweep_mode(SweepMode::in_background, 1);
    int passes = 0, passes_of_mixed_grids = 0;
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    do {
        ASSERT_EQ(session.render_pass(), PassEnd::complete);
        ++passes;
        passes_of_mixed_grids += session.sweeping() && session.stats().joint_builds > 1 ? 1 : 0;
    } while (session.sweeping() && std::chrono::steady_clock::now() < deadline);
    EXPECT_FALSE(session.sweeping());
    EXPECT_GT(passes_of_mixed_grids, 0) << "of " << passes;
    EXPECT_EQ(session.film().samples(), passes) << "the film was not cleared";
    EXPECT_EQ(session.stats().sweeps, 1);
    Session fresh(input, make_cpu_backend());
    fresh.prepare();
    EXPECT_TRUE(same_visibility(session, fresh));
}

TEST(SessionConcurrency, MeansWhileSweepsGoOn)
{
    constexpr int batches = 24;
    const int passes = test::effort(24);
    SessionInput input = edited_scene();
    input.visibility.cell = 2;
    input.visibility.directions = 16;
    input.visibility.epsilon = 0.05;
    const TransferFunction other = test::ct_transfer_function(0.02);
    for (const Strategy strategy : {Strategy::combined, Strategy::two_step}) {
        test::Moments synchronous, live;
        int passes_while_sweeping = 0;
        for (int which = 0; which < 2; ++which) {
            input.render.strategy = strategy;
            Session session(input, make_cpu_backend());
            if (which == 1)
                session.set_sweep_mode(SweepMode::in_background, 1);
            for (int b = 0; b < batches; ++b) {
                session.set_render({strategy, static_cast<std::uint64_t>(1000 * which + b)});
                if (which == 1) {
                    // V is the other medium's when passes begin, and becomes this one's.
                    session.set_transfer_function(other);
                    session.prepare();
                    session.set_transfer_function(input.transfer_function);
                }
                for (int p = 0; p < passes; ++p) {
                    session.render_pass();
                    passes_while_sweeping += session.sweeping() ? 1 : 0;
                }
                double sum = 0.0;
                for (const double c : session.film().color_sum())
                    sum += c;
                (which == 0 ? synchronous : live).add(sum / (passes * 3.0 * 32 * 32));
            }
        }
        EXPECT_GT(passes_while_sweeping, batches / 2);
        const double error = std::hypot(synchronous.standard_error(), live.standard_error());
        EXPECT_LT(error, (test::full_effort ? 0.01 : 0.04) * synchronous.mean());
        EXPECT_LT(std::fabs(synchronous.mean() - live.mean()), 4.0 * error) << name_of(strategy);
    }
}

TEST(SessionStages, MemoryCountsWhatRunsBesideRendering)
{
    const Vec3i size{512, 512, 460};
    const VisibilitySettings visibility;
    const auto needed = [&](auto... more) {
        return Session::memory_needed(size, {512, 512, true}, Strategy::two_step, visibility, more...);
    };
    const std::uint64_t cells = 128 * 128 * 115, joint = cells * 85 * 4, grid = cells * 64;
    EXPECT_GT(needed(), joint + grid);
    EXPECT_LT(needed(), (joint + grid) * 5 / 4);
    // Spare slots, the classified level and working memory beside the joint grid.
    EXPECT_GT(needed(SweepMode::in_background, 1), needed() + cells * 24 + 2 * 256 * 256 * 230);
    EXPECT_GT(needed(SweepMode::in_background, 4), needed(SweepMode::in_background, 1));
    Session session(edited_scene(), make_cpu_backend());
    EXPECT_ANY_THROW(session.set_sweep_mode(SweepMode::in_background, -1));
}

} // namespace
} // namespace lumisweep
