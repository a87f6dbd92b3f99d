// Paths on the device are the CPU's: the same random numbers, the same stages, the same bits.
#include <gtest/gtest.h>

#include "backends/cuda_scenes.h"

namespace lumisweep {
namespace {

/// With one collision a camera ray a pixel's sample is one number, so even its sums are the same.
void expect_the_scalar_image(SessionInput input, int passes, const std::string& what)
{
    const auto cuda = test::cuda_session(input), scalar = test::scalar_session(input);
    test::render(*cuda, passes);
    test::render(*scalar, passes);
    EXPECT_TRUE(test::same_paths(cuda->film(), scalar->film())) << what;
    const PassCounts &a = cuda->stats().counts, &b = scalar->stats().counts;
    EXPECT_EQ(a.paths, b.paths) << what;
    EXPECT_GT(a.shadow_rays, 0U) << what;
    const auto same = [&](std::uint64_t x, std::uint64_t y) {
        const double slack = test::same_arithmetic ? 0.0 : 0.01 * static_cast<double>(y);
        EXPECT_NEAR(static_cast<double>(x), static_cast<double>(y), slack) << what;
    };
    same(a.shadow_rays, b.shadow_rays);
    same(a.camera_steps, b.camera_steps);
    same(a.shadow_steps, b.shadow_steps);
    same(a.advance_steps, b.advance_steps);
}

TEST(CudaPaths, AreTheScalarOnesForEveryStrategy)
{
    for (const Strategy strategy : test::all_strategies) {
        if (strategy == Strategy::automatic)
            continue; // several collisions: below
        SessionInput input = test::small_ct();
        input.render.strategy = strategy;
        expect_the_scalar_image(input, 3, name_of(strategy));
    }
}

TEST(CudaPaths, AreTheScalarOnesInThinMediaThroughALens)
{
    SessionInput input = test::small_smoke();
    input.render.strategy = Strategy::two_step;
    expect_the_scalar_image(input, 3, "smoke");
    input.image.show_environment = false;
    input.render.random_numbers = RandomNumbers::stratified;
    expect_the_scalar_image(input, 18, "smoke, stratified, without background"); // more than a block
}

TEST(CudaPaths, AreTheScalarOnesForEveryVoxelType)
{
    const Vec3i size{17, 12, 9};
    const Affine3d place = test::centered(size, {2.0, 1.5, 3.0});
    const auto value = [](int i, int j, int k) { return (i * 7 + j * 13 + k * 29) % 97; };
    SessionInput input = test::small_ct();
    input.render.strategy = Strategy::two_step;
    input.transfer_function = TransferFunction({{20.0, 0.0, {0.9, 0.8, 0.7}}, {90.0, 0.4, {0.5, 0.6, 0.7}}});
    input.volume = test::make_grid<std::uint8_t>(VoxelType::u8, size, place, value);
    expect_the_scalar_image(input, 2, "u8");
    input.volume = test::make_grid<std::uint16_t>(VoxelType::u16, size, place, value, 0.5, 3.0);
    expect_the_scalar_image(input, 2, "u16");
    input.volume = test::make_grid<std::int16_t>(VoxelType::i16, size, place, value, -1.0, 100.0);
    expect_the_scalar_image(input, 2, "i16");
    input.volume = test::make_grid<float>(VoxelType::f32, size, place, value);
    expect_the_scalar_image(input, 2, "f32");
}

TEST(CudaPaths, AreTheScalarOnesInVolumesOneVoxelThick)
{
    for (const Vec3i size : {Vec3i{1, 20, 20}, {20, 1, 20}, {20, 20, 1}, {1, 1, 1}}) {
        SessionInput input = test::small_ct();
        input.volume = test::make_grid<float>(VoxelType::f32, size, test::centered(size, {1.0, 1.0, 1.0}),
                                              [](int i, int j, int k) { return i + j + k + 1; });
        input.transfer_function = TransferFunction({{0.0, 0.0, {1.0, 1.0, 1.0}}, {40.0, 2.0, {0.9, 0.9, 0.9}}});
        input.camera.position = {9.0, -30.0, 7.0};
        input.render.strategy = Strategy::two_step;
        expect_the_scalar_image(input, 4, std::to_string(size.x) + " " + std::to_string(size.y));
    }
}

// With several collisions a camera ray the light of a sample is a sum, whose order differs.
TEST(CudaPaths, SeveralCollisionsDifferByRounding)
{
    for (const SessionInput& scene : {test::small_ct(), test::small_smoke()}) {
        SessionInput input = scene;
        input.render.strategy = Strategy::automatic;
        input.render.shadow_rays = 5;
        const auto cuda = test::cuda_session(input), scalar = test::scalar_session(input);
        test::render(*cuda, 20);
        test::render(*scalar, 20);
        if (!test::same_arithmetic) {
            EXPECT_TRUE(test::same_paths(cuda->film(), scalar->film()));
            continue;
        }
        EXPECT_TRUE(test::same_bits(cuda->film().features(), scalar->film().features()));
        const AlignedArray<double>&a = cuda->film().color_sum(), &b = scalar->film().color_sum();
        for (std::size_t i = 0; i < a.size(); ++i)
            ASSERT_NEAR(a[i], b[i], 1e-6 * std::fabs(b[i])) << i;
    }
}

TEST(CudaPaths, ImageSidesThatSquaresDoNotDivide)
{
    for (const auto& [width, height] : {std::pair{1, 1}, {7, 9}, {8, 8}, {65, 3}}) {
        SessionInput input = test::small_ct();
        input.render.strategy = Strategy::environment;
        input.image = {width, height, true};
        const auto cuda = test::cuda_session(input), scalar = test::scalar_session(input);
        test::render(*cuda, 5);
        test::render(*scalar, 5);
        EXPECT_TRUE(test::same_paths(cuda->film(), scalar->film())) << width << " × " << height;
    }
}

} // namespace
} // namespace lumisweep
