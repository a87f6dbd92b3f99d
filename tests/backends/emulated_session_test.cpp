// What only the emulated device can tell of sessions: what is uploaded, and what does not fit.
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

} // namespace
} // namespace lumisweep
