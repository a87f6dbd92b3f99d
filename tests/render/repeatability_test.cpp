// The same scene, seed and samples give the same bits; instruction sets agree within rounding; setters leave nothing
// stale.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <thread>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "support/effort.h"
#include "support/films.h"
#include "support/scenes.h"

namespace lumisweep {
namespace {

SessionInput ct_scene(Vec3i size = {27, 30, 25})
{
    SessionInput input;
    input.volume = test::ct_like(size, test::centered(size, {1.0, 1.1, 0.9}));
    input.transfer_function = test::ct_transfer_function();
    input.environment = test::sky_with_sun(64);
    input.image = {101, 67, true};
    input.camera.position = {25.0, -70.0, 20.0};
    input.camera.vertical_fov_deg = 30.0;
    return input;
}

TEST(Repeatability, SameBitsForAnyNumberOfThreads)
{
    const tbb::global_control seven(tbb::global_control::max_allowed_parallelism, 7);
    for (const auto& [width, height] : {std::pair{101, 67}, {1, 1}, {33, 1}, {300, 257}}) {
        for (const std::string& isa : available_isas()) {
            SessionInput input = ct_scene();
            input.image = {width, height, true};
            std::unique_ptr<Session> one;
            for (const int threads : {1, 2, 7}) {
                tbb::task_arena arena(threads);
                std::unique_ptr<Session> session;
                arena.execute([&] { session = test::rendered(input, 3, isa); });
                if (threads == 1)
                    one = std::move(session);
                else
                    EXPECT_TRUE(test::same_film(one->film(), session->film()))
                        << threads << " threads, " << isa << ", " << width;
            }
        }
    }
}

/// Leaves NaN all over the stack below the caller.
__attribute__((noinline)) void soil_stack()
{
    volatile std::uint32_t garbage[128 * 1024];
    for (volatile std::uint32_t& word : garbage)
        word = 0xffffffffU;
}

// Groups of paths at the end of a stream are not full: lanes without a path must not read what nobody wrote.
TEST(Repeatability, NothingDependsOnWhatTheStackHeld)
{
    for (const std::string& isa : available_isas()) {
        tbb::task_arena arena(1);
        const SessionInput input = ct_scene({28, 31, 25});
        std::unique_ptr<Session> clean, soiled;
        arena.execute([&] { clean = test::rendered(input, 1, isa); });
        arena.execute([&] {
            soiled = std::make_unique<Session>(input, make_cpu_backend(isa));
            soiled->prepare();
            soil_stack();
            soiled->render_pass();
        });
        EXPECT_TRUE(test::same_film(clean->film(), soiled->film())) << isa;
    }
}

TEST(Repeatability, CancelledPassesLeaveNoTrace)
{
    const SessionInput input = ct_scene();
    const auto straight = test::rendered(input, 4);
    Session session(input, make_cpu_backend());
    std::atomic<bool> cancel = true;
    EXPECT_EQ(session.render_pass(&cancel), PassEnd::cancelled); // before the sweep
    cancel = false;
    session.render_pass(&cancel);
    cancel = true;
    EXPECT_EQ(session.render_pass(&cancel), PassEnd::cancelled);
    EXPECT_EQ(session.film().samples(), 1);
    cancel = false;
    // From another thread, somewhere within a pass.
    for (int i = 0; i < 20; ++i) {
        std::thread canceller([&] {
            const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(50 * i);
            while (std::chrono::steady_clock::now() < end) {
            }
            cancel = true;
        });
        const std::int64_t before = session.film().samples();
        const PassEnd end = session.render_pass(&cancel);
        EXPECT_EQ(session.film().samples(), before + (end == PassEnd::complete ? 1 : 0));
        canceller.join();
        cancel = false;
        if (session.film().samples() >= 3)
            break;
    }
    while (session.film().samples() < 4)
        session.render_pass();
    EXPECT_TRUE(test::same_film(straight->film(), session.film()));
}

TEST(Repeatability, RestoredFilmGoesOnAsIfNothingHappened)
{
    const SessionInput input = ct_scene();
    const auto straight = test::rendered(input, 37); // two blocks and some
    const auto first = test::rendered(input, 21);
    Film saved(input.image.width, input.image.height);
    std::copy(first->film().color_sum().begin(), first->film().color_sum().end(), saved.arrays().color_sum.begin());
    std::copy(first->film().arrays().color_sum_squares.begin(), first->film().arrays().color_sum_squares.end(),
              saved.arrays().color_sum_squares.begin());
    std::copy(first->film().arrays().block_sum_squares.begin(), first->film().arrays().block_sum_squares.end(),
              saved.arrays().block_sum_squares.begin());
    std::copy(first->film().arrays().block_begin.begin(), first->film().arrays().block_begin.end(),
              saved.arrays().block_begin.begin());
    std::copy(first->film().features().begin(), first->film().features().end(), saved.arrays().features.begin());
    saved.set_samples(21);
    Session resumed(input, make_cpu_backend());
    resumed.restore_film(std::move(saved));
    for (int i = 0; i < 16; ++i)
        resumed.render_pass();
    EXPECT_TRUE(test::same_film(straight->film(), resumed.film()));
    EXPECT_ANY_THROW(resumed.restore_film(Film(3, 4)));
}

TEST(Repeatability, InstructionSetsAgreePixelByPixel)
{
    for (const Strategy strategy : test::all_strategies) {
        SessionInput input = ct_scene();
        input.render.strategy = strategy;
        const auto reference = test::rendered(input, 1, "baseline");
        for (const std::string& isa : available_isas()) {
            const auto session = test::rendered(input, 1, isa);
            int close = 0, lit = 0;
            for (std::size_t i = 0; i < session->film().color_sum().size(); ++i) {
                const double a = session->film().color_sum()[i], b = reference->film().color_sum()[i];
                lit += a != 0.0 || b != 0.0 ? 1 : 0;
                close += (a != 0.0 || b != 0.0) && std::fabs(a - b) <= 1e-3 * std::max(a, b) ? 1 : 0;
            }
            EXPECT_GT(lit, 1000);
            EXPECT_GE(close, 0.99 * lit) << isa << " " << name_of(strategy);
        }
    }
}

TEST(Repeatability, TheSeedAndTheSampleChangeTheNoise)
{
    SessionInput input = ct_scene();
    const auto a = test::rendered(input, 1);
    input.render.seed = 1;
    const auto b = test::rendered(input, 1);
    int differing = 0;
    for (std::size_t i = 0; i < a->film().color_sum().size(); ++i)
        differing += a->film().color_sum()[i] != b->film().color_sum()[i] ? 1 : 0;
    EXPECT_GT(differing, 3000);
}

// Every setter between passes gives what a fresh session gives, in any order.
// Many shadow rays a camera ray: their streams fill up in other ways.
TEST(Repeatability, SameBitsForAnyNumberOfShadowRaysAndThreads)
{
    const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
    for (const int shadow_rays : {3, 4, 64}) {
        for (const RandomNumbers numbers : {RandomNumbers::independent, RandomNumbers::stratified}) {
            for (const std::string& isa : available_isas()) {
                SessionInput input = ct_scene();
                if (shadow_rays == 4) // tiles of the other size
                    input.image = {300, 257, true};
                input.render.shadow_rays = shadow_rays;
                input.render.random_numbers = numbers;
                std::unique_ptr<Session> one, other;
                tbb::task_arena(1).execute([&] { one = test::rendered(input, 2, isa); });
                tbb::task_arena(2).execute([&] { other = test::rendered(input, 2, isa); });
                EXPECT_TRUE(test::same_film(one->film(), other->film())) << shadow_rays << " shadow rays, " << isa;
                EXPECT_EQ(one->stats().counts.shadow_rays, other->stats().counts.shadow_rays);
                EXPECT_EQ(one->stats().counts.camera_steps, other->stats().counts.camera_steps);
            }
        }
    }
}

TEST(Repeatability, SettersLeaveNothingStale)
{
    const SessionInput start = ct_scene();
    SessionInput other = ct_scene({40, 22, 31});
    other.transfer_function = test::ct_transfer_function(0.5);
    other.environment = test::constant_light({0.2, 0.3, 0.4});
    other.camera.position = {-60.0, -30.0, 10.0};
    other.image = {50, 40, false};
    other.render = {Strategy::combined, 77};
    other.visibility.directions = 16;
    other.visibility.cell = 5;
    using Change = void (*)(SessionInput&, Session&, const SessionInput&);
    const Change changes[] = {
        [](SessionInput& i, Session& s, const SessionInput& o) { s.set_volume(i.volume = o.volume); },
        [](SessionInput& i, Session& s, const SessionInput& o) {
            s.set_transfer_function(i.transfer_function = o.transfer_function);
        },
        [](SessionInput& i, Session& s, const SessionInput& o) { s.set_environment(i.environment = o.environment); },
        [](SessionInput& i, Session& s, const SessionInput& o) { s.set_camera(i.camera = o.camera); },
        [](SessionInput& i, Session& s, const SessionInput& o) { s.set_image(i.image = o.image); },
        [](SessionInput& i, Session& s, const SessionInput& o) { s.set_render(i.render = o.render); },
        [](SessionInput& i, Session& s, const SessionInput& o) { s.set_visibility(i.visibility = o.visibility); },
    };
    const int orders[][7] = {{0, 1, 2, 3, 4, 5, 6}, {6, 5, 4, 3, 2, 1, 0}, {5, 2, 6, 0, 3, 1, 4}};
    for (const auto& order : orders) {
        for (const Strategy first : {Strategy::two_step, Strategy::uniform}) {
            SessionInput input = start;
            input.render.strategy = first;
            Session session(input, make_cpu_backend());
            session.render_pass();
            for (const int c : order) {
                changes[c](input, session, other);
                session.render_pass();
                session.render_pass();
                EXPECT_TRUE(test::same_film(test::rendered(input, 2)->film(), session.film())) << "change " << c;
            }
        }
    }
}

TEST(Repeatability, RefusesWhatMakesNoSense)
{
    SessionInput input = ct_scene();
    const auto backend = make_cpu_backend();
    const auto refuses = [&](auto&& change) {
        SessionInput bad = input;
        change(bad);
        EXPECT_ANY_THROW(Session(bad, backend));
    };
    refuses([](SessionInput& i) { i.volume = nullptr; });
    refuses([](SessionInput& i) { i.environment = nullptr; });
    refuses([](SessionInput& i) { i.camera.target = i.camera.position; });
    refuses([](SessionInput& i) { i.camera.up = i.camera.target - i.camera.position; });
    refuses([](SessionInput& i) { i.camera.vertical_fov_deg = 180.0; });
    refuses([](SessionInput& i) { i.camera.lens_radius = -1.0; });
    refuses([](SessionInput& i) { i.camera.position.x = std::nan(""); });
    refuses([](SessionInput& i) { i.image.width = 0; });
    refuses([](SessionInput& i) { i.visibility.cell = 0; });
    refuses([](SessionInput& i) { i.visibility.directions = 7; });
    refuses([](SessionInput& i) { i.visibility.epsilon = 0.0; });
    refuses([](SessionInput& i) { i.visibility.epsilon = 1e-50; }); // zero in single precision: light would be lost
    refuses([](SessionInput& i) { i.visibility.epsilon = std::nan(""); });
    refuses([](SessionInput& i) { i.render.shadow_rays = 65; });
    refuses([](SessionInput& i) { i.render.shadow_rays = -1; });
    EXPECT_ANY_THROW(make_cpu_backend("sse9"));
    Session session(input, backend);
    EXPECT_ANY_THROW(session.replace_visibility(VisibilityGrid({8, 8, 8}, 4, 8)));
    EXPECT_ANY_THROW(session.set_volume(nullptr));
    EXPECT_ANY_THROW(session.set_environment(nullptr));
    EXPECT_EQ(session.render_pass(), PassEnd::complete); // still whole
}

} // namespace
} // namespace lumisweep
