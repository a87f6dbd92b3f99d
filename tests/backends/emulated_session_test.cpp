// What only the emulated device can tell of sessions: what is uploaded, and what does not fit.
#include <functional>

#include <gtest/gtest.h>

#include "backends/cuda_scenes.h"
#include "backends/emulated_device.h"
#include "lumisweep/base/error.h"

namespace lumisweep {
namespace {

TEST(EmulatedSession, VolumesThatWereFetchedBeforeArriveOnce)
{
    SessionInput input = test::two_step_ct();
    const auto session = test::cuda_session(input);
    test::render(*session, 1);
    // In the same place, so that the sweeps' plan stays.
    const std::shared_ptr<const ScalarGrid> next =
        test::make_grid<std::int16_t>(VoxelType::i16, input.volume->size(), input.volume->world_from_voxel(),
                                      [](int i, int j, int k) { return (i * j + 7 * k) % 13 * 100; });
    const std::uint64_t before = test::bytes_uploaded();
    session->prefetch(next);
    test::render(*session, 3);
    session->set_volume(input.volume = next);
    test::expect_fresh(*session, input, "fetched before");
    EXPECT_LT(test::bytes_uploaded() - before, next->bytes() + 16384);
    // One that is fetched and not used, and one that is used and was not fetched.
    session->prefetch(test::small_ct().volume);
    session->set_volume(input.volume = test::ct_like({21, 22, 23}, test::centered({21, 22, 23}, {1, 1, 1})));
    test::expect_fresh(*session, input, "not the one fetched");
}

TEST(EmulatedSession, AnEditOfTheTransferFunctionUploadsLittleElse)
{
    const auto session = test::cuda_session(test::two_step_ct());
    test::render(*session, 1);
    session->set_transfer_function(test::ct_transfer_function(0.5));
    const std::uint64_t before = test::bytes_uploaded();
    test::render(*session, 1);
    EXPECT_LT(test::bytes_uploaded() - before, 8192U);
}

TEST(EmulatedSession, SaysWhatDoesNotFitIntoTheDevicesMemory)
{
    const std::uint64_t taken = test::emulated_memory_taken();
    for (const std::uint64_t memory : {1000U, 100000U, 400000U, 1000000U}) {
        test::set_emulated_memory(taken + memory);
        try {
            const auto session = test::cuda_session(test::two_step_ct());
            session->render_pass();
            ADD_FAILURE() << memory;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("of the GPU's memory"), std::string::npos) << error.what();
        }
        EXPECT_EQ(test::emulated_memory_taken(), taken);
    }
    test::set_emulated_memory(std::uint64_t{1} << 40);
    test::expect_fresh(*test::cuda_session(test::two_step_ct()), test::two_step_ct(), "with enough memory again");
}

// Whatever allocation fails in whatever edit: the session says so, and is whole again with the next pass.
TEST(EmulatedSession, StaysWholeWhenAnAllocationFails)
{
    const Vec3i larger{40, 38, 36};
    const std::shared_ptr<const ScalarGrid> volume = test::ct_like(larger, test::centered(larger, {1.0, 1.0, 1.0}));
    const auto light = test::sky_with_sun(128);
    using Edit = std::function<void(Session&, SessionInput&)>;
    const Edit edits[] = {
        [&](Session& s, SessionInput& input) { s.set_volume(input.volume = volume); },
        [&](Session& s, SessionInput& input) { s.set_environment(input.environment = light); },
        [](Session& s, SessionInput& input) {
            input.image = {70, 61, true};
            s.set_image(input.image);
        },
        [](Session& s, SessionInput& input) {
            input.visibility.directions = 16;
            input.visibility.cell = 2;
            s.set_visibility(input.visibility);
        },
        [](Session& s, SessionInput& input) {
            s.set_transfer_function(input.transfer_function = test::smoke_transfer_function());
        },
    };
    for (const Edit& edit : edits) {
        bool failed = true;
        for (int more = 0; failed; ++more) {
            SessionInput input = test::two_step_ct();
            const auto session = test::cuda_session(input);
            test::render(*session, 3);
            test::fail_allocation_after(more);
            failed = false;
            try {
                edit(*session, input);
                session->render_pass();
                EXPECT_GE(session->film().color_sum()[0], 0.0);
            } catch (const Error&) {
                failed = true;
            }
            test::fail_allocation_after(-1);
            if (failed) {
                // The edit itself may have been refused: what counts is that the session does what it says it has.
                input = session->input();
                EXPECT_GE(session->film().color_sum()[0], 0.0);
                session->visibility();
                session->set_camera(input.camera);
                test::expect_fresh(*session, input, "after allocation " + std::to_string(more));
            }
        }
    }
}

// As long as nothing has been swept in the new shape the grid is the old one.
TEST(EmulatedSession, TheGridOfAVolumeBeforeCanBeLookedAt)
{
    SessionInput input = test::two_step_ct();
    const auto session = test::cuda_session(input);
    ASSERT_TRUE(session->prepare());
    input.render.strategy = Strategy::uniform;
    session->set_render(input.render);
    const Vec3i smaller{9, 8, 7};
    session->set_volume(test::ct_like(smaller, test::centered(smaller, {1.0, 1.0, 1.0})));
    test::render(*session, 1);
    EXPECT_EQ(session->visibility().cell_count(), 7U * 8U * 7U); // of 27 × 30 × 25 voxels
}

// In whatever order: set_volume() is lazy.
TEST(EmulatedSession, TheNextVolumeMayBeFetchedRightAfterASet)
{
    SessionInput input = test::two_step_ct();
    const auto volume = [&](int seed) {
        return test::make_grid<std::int16_t>(VoxelType::i16, input.volume->size(), input.volume->world_from_voxel(),
                                             [=](int i, int j, int k) { return (i * j + seed * k) % 13 * 100; });
    };
    const std::shared_ptr<const ScalarGrid> b = volume(3), c = volume(5);
    const auto session = test::cuda_session(input);
    test::render(*session, 1);
    const std::uint64_t before = test::bytes_uploaded();
    session->prefetch(b);
    session->set_volume(b);
    session->prefetch(c);
    test::render(*session, 1);
    session->set_volume(input.volume = c);
    session->prefetch(c); // is there
    test::expect_fresh(*session, input, "the second");
    EXPECT_LT(test::bytes_uploaded() - before, 2 * b->bytes() + 32768);
}

TEST(EmulatedSession, PendingPassesAreDrawnWithTheGridThatTheyWereBegunWith)
{
    const auto looked_at = test::cuda_session(test::two_step_ct()),
               left_alone = test::cuda_session(test::two_step_ct());
    for (Session* session : {looked_at.get(), left_alone.get()}) {
        test::render(*session, 2);
        if (session == looked_at.get())
            session->wait_for_passes();
        const SessionInput& input = session->input();
        session->replace_visibility(
            VisibilityGrid(input.volume->size(), input.visibility.cell, input.visibility.directions));
        test::render(*session, 2);
    }
    EXPECT_TRUE(test::same_film(looked_at->film(), left_alone->film()));
}

} // namespace
} // namespace lumisweep
