// A session on the device: what its edits redo, and what its passes leave when they are looked at, cancelled or
// resumed.
#include <gtest/gtest.h>

#include <thread>

#include "backends/cuda_scenes.h"

namespace lumisweep {
namespace {

TEST(CudaSession, EditsLeaveNothingStale)
{
    SessionInput input = test::two_step_ct();
    const auto session = test::cuda_session(input);
    test::expect_fresh(*session, input, "first");
    session->set_transfer_function(input.transfer_function = test::ct_transfer_function(0.3));
    test::expect_fresh(*session, input, "transfer function");
    session->set_environment(input.environment =
                                 test::one_texel_light(16, {1.0, 0.2, 0.4}, {5.0, 4.0, 3.0}, {0.1, 0.2, 0.3}));
    test::expect_fresh(*session, input, "environment");
    input.visibility.epsilon = 0.02;
    session->set_visibility(input.visibility);
    test::expect_fresh(*session, input, "epsilon");
    input.visibility.directions = 4;
    input.visibility.cell = 3;
    session->set_visibility(input.visibility);
    test::expect_fresh(*session, input, "directions and cell");
    input.camera.position = {-30.0, -50.0, 10.0};
    session->set_camera(input.camera);
    test::expect_fresh(*session, input, "camera");
    input.image = {40, 20, false};
    session->set_image(input.image);
    test::expect_fresh(*session, input, "image");
    input.render.strategy = Strategy::visibility;
    input.render.seed = 5;
    session->set_render(input.render);
    test::expect_fresh(*session, input, "strategy and seed");
    const Vec3i size{20, 33, 18};
    session->set_volume(input.volume = test::ct_like(size, test::centered(size, {1.2, 1.0, 1.0})));
    test::expect_fresh(*session, input, "volume");
    input.visibility.directions = 128 / 4;
    session->set_visibility(input.visibility);
    input.environment = test::constant_light();
    session->set_environment(input.environment);
    test::expect_fresh(*session, input, "a light coarser than the directions");
}

TEST(CudaSession, LookingBetweenPassesChangesNothing)
{
    const auto looked_at = test::cuda_session(test::two_step_ct()),
               left_alone = test::cuda_session(test::two_step_ct());
    for (int i = 0; i < 40; ++i) {
        looked_at->render_pass();
        if (i % 7 == 3) {
            EXPECT_GE(looked_at->film().color_sum()[0], 0.0);
        }
        left_alone->render_pass();
        EXPECT_EQ(looked_at->film().samples(), i + 1);
    }
    EXPECT_TRUE(test::same_film(looked_at->film(), left_alone->film()));
}

/// More pixels than one launch draws.
constexpr int large_side = test::same_arithmetic ? 300 : 2200;

TEST(CudaSession, LargeImagesAreDrawnInParts)
{
    SessionInput input = test::two_step_ct();
    input.image = {large_side, large_side, true};
    const auto cuda = test::cuda_session(input), scalar = test::scalar_session(input);
    test::render(*cuda, 2);
    test::render(*scalar, 2);
    EXPECT_TRUE(test::same_paths(cuda->film(), scalar->film()));
}

TEST(CudaSession, ACancelledPassLeavesNoTrace)
{
    for (const int side : {40, large_side}) {
        SessionInput input = test::two_step_ct();
        input.image = {side, side, true};
        const auto session = test::cuda_session(input), undisturbed = test::cuda_session(input);
        test::render(*session, 1);
        std::atomic<bool> cancel = true;
        EXPECT_EQ(session->render_pass(&cancel), PassEnd::cancelled);
        cancel = false;
        std::thread canceller([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
            cancel = true;
        });
        int begun = 1;
        while (session->render_pass(&cancel) == PassEnd::complete)
            ++begun;
        canceller.join();
        EXPECT_EQ(session->film().samples(), begun);
        test::render(*session, 1);
        test::render(*undisturbed, begun + 1);
        EXPECT_TRUE(test::same_film(session->film(), undisturbed->film())) << side;
    }
}

TEST(CudaSession, ACancelledSweepIsDoneAgain)
{
    const auto session = test::cuda_session(test::two_step_ct());
    const std::atomic<bool> cancel = true;
    EXPECT_FALSE(session->prepare(&cancel));
    test::expect_fresh(*session, test::two_step_ct(), "after a cancelled sweep");
}

TEST(CudaSession, GoesOnFromACheckpoint)
{
    const auto whole = test::cuda_session(test::two_step_ct()), first = test::cuda_session(test::two_step_ct()),
               second = test::cuda_session(test::two_step_ct());
    test::render(*whole, 25);
    test::render(*first, 10);
    Film saved(first->film().width(), first->film().height());
    const FilmArrays& from = first->film().arrays();
    FilmArrays& to = saved.arrays();
    for (const auto& [a, b] : {std::pair{&from.color_sum, &to.color_sum},
                               {&from.color_sum_squares, &to.color_sum_squares},
                               {&from.block_sum_squares, &to.block_sum_squares},
                               {&from.block_begin, &to.block_begin}})
        std::copy(a->begin(), a->end(), b->begin());
    std::copy(from.features.begin(), from.features.end(), to.features.begin());
    saved.set_samples(10);
    second->restore_film(std::move(saved));
    EXPECT_EQ(second->film().samples(), 10);
    test::render(*second, 15);
    EXPECT_TRUE(test::same_film(second->film(), whole->film()));
}

TEST(CudaSession, TheVisibilityGridIsTheCpus)
{
    const auto cuda = test::cuda_session(test::two_step_ct()), scalar = test::scalar_session(test::two_step_ct());
    ASSERT_TRUE(cuda->prepare());
    ASSERT_TRUE(scalar->prepare());
    const VisibilityGrid &a = cuda->visibility(), &b = scalar->visibility();
    ASSERT_TRUE(a.same_shape(b));
    for (int d = 0; d < a.direction_count(); ++d)
        ASSERT_EQ(std::memcmp(a.direction(d), b.direction(d), a.cell_count()), 0) << d;
}

// The poisoned cache: the samples change, the mean does not.
TEST(CudaSession, WhateverTheGridHoldsTheMeanStays)
{
    SessionInput input = test::two_step_ct();
    input.image = {48, 48, false};
    const auto right = test::cuda_session(input);
    test::render(*right, 64);
    const auto mean = [](const Session& session) {
        double sum = 0.0, variance = 0.0;
        const Film& film = session.film();
        for (std::size_t i = 0; i < film.color_sum().size(); ++i) {
            sum += film.color_sum()[i] / static_cast<double>(film.samples());
            variance += film.unbiased_variance_of_mean(i);
        }
        return std::pair{sum, variance};
    };
    const auto [expected, its_variance] = mean(*right);
    for (int poison = 0; poison < 3; ++poison) {
        const auto session = test::cuda_session(input);
        ASSERT_TRUE(session->prepare());
        VisibilityGrid grid(input.volume->size(), input.visibility.cell, input.visibility.directions);
        for (int d = 0; d < grid.direction_count(); ++d)
            for (std::size_t c = 0; c < grid.cell_count(); ++c)
                grid.direction(d)[c] = poison == 0   ? std::uint8_t{0}
                                       : poison == 1 ? std::uint8_t{255}
                                                     : static_cast<std::uint8_t>((d * 7919 + c * 104729) >> 3);
        session->replace_visibility(std::move(grid));
        test::render(*session, 64);
        const auto [found, variance] = mean(*session);
        // The channels of a pixel are correlated: three times the variance at most.
        EXPECT_LE(std::fabs(found - expected), 4.0 * std::sqrt(3.0 * (variance + its_variance))) << poison;
    }
}

TEST(CudaSession, SweepsBesideRenderingAreSweepsBefore)
{
    const auto session = test::cuda_session(test::two_step_ct());
    session->set_sweep_mode(SweepMode::in_background);
    test::expect_fresh(*session, test::two_step_ct(), "in the background");
    EXPECT_FALSE(session->sweeping());
}

TEST(CudaSession, BlackLight)
{
    SessionInput input = test::two_step_ct();
    input.environment = test::constant_light({0.0, 0.0, 0.0});
    test::expect_fresh(*test::cuda_session(input), input, "black");
}

} // namespace
} // namespace lumisweep
