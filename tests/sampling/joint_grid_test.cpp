// The joint grid against its definition, on every instruction set and shape; and that a rebuild is in place.
#include <gtest/gtest.h>

#include "lumisweep/base/error.h"

#include <bit>
#include <cstring>

#include "sampling/direction_cases.h"

namespace lumisweep {
namespace {

VisibilityGrid random_visibility(Vec3i size, int voxels_per_cell, int directions, unsigned seed)
{
    VisibilityGrid grid(size, voxels_per_cell, directions);
    std::mt19937 random(seed);
    for (int d = 0; d < grid.direction_count(); ++d)
        for (std::size_t c = 0; c < grid.cell_count(); ++c)
            grid.direction(d)[c] = static_cast<std::uint8_t>(random() & 255U);
    return grid;
}

Environment random_light(int n)
{
    std::mt19937 random(5);
    return test::make_environment(n, [&](int, int) {
        return Vec3d{0.1 + static_cast<double>(random() % 100), 1.0, static_cast<double>(random() % 7)};
    });
}

/// The definition in JointView's words, one cell after the other, in the same precision and order of rounding.
struct PlainJoint {
    std::vector<float> nodes, root;
    PlainJoint(const VisibilityGrid& visibility, const Environment& light, JointFactor factor, float epsilon)
    {
        const auto directions = static_cast<std::size_t>(visibility.direction_count());
        const float* luminance = light.view().luminance + (directions - 1) / 3;
        for (std::size_t cell = 0; cell < visibility.cell_count(); ++cell) {
            std::vector<std::vector<float>> levels(1);
            for (std::size_t d = 0; d < directions; ++d) {
                const float v = static_cast<float>(visibility.direction(static_cast<int>(d))[cell]) * (1.0F / 255.0F);
                const float l = factor == JointFactor::visibility_only
                                    ? 1.0F
                                    : static_cast<float>(luminance[d] / light.mean_luminance());
                levels[0].push_back((v + epsilon) * l);
            }
            while (levels.back().size() > 1) {
                const std::vector<float>& c = levels.back();
                std::vector<float> means;
                for (std::size_t m = 0; m < c.size(); m += 4)
                    means.push_back(0.25F * ((c[m] + c[m + 1]) + (c[m + 2] + c[m + 3])));
                levels.push_back(means);
            }
            root.push_back(levels.back()[0]);
            for (std::size_t l = levels.size() - 1; l-- > 0;)
                nodes.insert(nodes.end(), levels[l].begin(), levels[l].end());
        }
    }
};

::testing::AssertionResult same_as(const JointGrid& joint, const PlainJoint& plain)
{
    const JointView view = joint.view();
    const std::size_t nodes = plain.root.size() * static_cast<std::size_t>(view.node_count);
    if (view.levels > 0 && nodes != plain.nodes.size())
        return ::testing::AssertionFailure() << nodes << " nodes, not " << plain.nodes.size();
    if (std::memcmp(view.root, plain.root.data(), plain.root.size() * sizeof(float)) != 0)
        return ::testing::AssertionFailure() << "roots differ";
    if (view.levels > 0 && std::memcmp(view.nodes, plain.nodes.data(), nodes * sizeof(float)) != 0)
        return ::testing::AssertionFailure() << "nodes differ";
    return ::testing::AssertionSuccess();
}

TEST(JointGridTest, IsItsDefinitionToTheBit)
{
    const Vec3i sizes[] = {{1, 1, 1}, {13, 10, 21}, {64, 64, 1}, {3, 67, 41}};
    for (const int n : {1, 2, 4, 8, 16, 32}) {
        const Environment light = random_light(32);
        for (const Vec3i& size : sizes) {
            const VisibilityGrid visibility = random_visibility(size, 3, n, 1);
            for (const JointFactor factor : {JointFactor::visibility_only, JointFactor::visibility_times_light}) {
                const PlainJoint plain(visibility, light, factor, 0.1F);
                for (const JointKernel* const* kernel = joint_kernels(); *kernel != nullptr; ++kernel) {
                    JointGrid joint;
                    joint.build(visibility, size, light, factor, 0.1F, nullptr, **kernel);
                    EXPECT_TRUE(same_as(joint, plain))
                        << (*kernel)->name << ", " << n << ", " << size.x << " x " << size.y << " x " << size.z;
                }
            }
        }
    }
}

// Large enough for stores past the caches, with an incomplete last block.
TEST(JointGridTest, StreamsLargeGrids)
{
    const Vec3i size{37, 41, 43};
    const VisibilityGrid visibility = random_visibility(size, 1, 8, 2);
    const Environment light = random_light(8);
    const PlainJoint plain(visibility, light, JointFactor::visibility_times_light, 0.01F);
    for (const JointKernel* const* kernel = joint_kernels(); *kernel != nullptr; ++kernel) {
        JointGrid joint;
        joint.build(visibility, size, light, JointFactor::visibility_times_light, 0.01F, nullptr, **kernel);
        ASSERT_GT(joint.bytes(), std::size_t{20} << 20);
        EXPECT_TRUE(same_as(joint, plain)) << (*kernel)->name;
    }
}

TEST(JointGridTest, RebuildsInPlaceAndForgetsTheOld)
{
    const Vec3i size{21, 22, 9};
    const Environment light = random_light(16);
    JointGrid joint(random_visibility(size, 2, 8, 3), size, light, JointFactor::visibility_only, 0.5);
    const JointView before = joint.view();
    const VisibilityGrid other = random_visibility(size, 2, 8, 4);
    joint.build(other, size, light, JointFactor::visibility_times_light, 0.1F);
    EXPECT_EQ(joint.view().nodes, before.nodes);
    EXPECT_EQ(joint.view().root, before.root);
    EXPECT_TRUE(same_as(joint, PlainJoint(other, light, JointFactor::visibility_times_light, 0.1F)));
    for (const int n : {1, 16, 2, 8}) { // other shapes
        const VisibilityGrid reshaped = random_visibility({8, 9, 7}, n > 4 ? 1 : 3, n, 5);
        joint.build(reshaped, {8, 9, 7}, light, JointFactor::visibility_times_light, 0.1F);
        EXPECT_TRUE(same_as(joint, PlainJoint(reshaped, light, JointFactor::visibility_times_light, 0.1F))) << n;
        EXPECT_EQ(joint.bytes(), JointGrid::bytes_needed(reshaped.cell_count(), n));
    }
}

TEST(JointGridTest, CancelledItIsIncomplete)
{
    const Vec3i size{64, 64, 20};
    const Environment light = random_light(8);
    const VisibilityGrid visibility = random_visibility(size, 1, 8, 6);
    JointGrid joint;
    std::atomic<bool> cancel = true;
    EXPECT_FALSE(joint.build(visibility, size, light, JointFactor::visibility_times_light, 0.1F, &cancel));
    cancel = false;
    EXPECT_TRUE(joint.build(visibility, size, light, JointFactor::visibility_times_light, 0.1F, &cancel));
    EXPECT_TRUE(same_as(joint, PlainJoint(visibility, light, JointFactor::visibility_times_light, 0.1F)));
}

TEST(JointGrid, RefusesMoreThanKernelsCanIndex)
{
    EXPECT_NO_THROW(JointGrid::require_indexable(std::size_t{1} << 24, 8));
    EXPECT_THROW(JointGrid::require_indexable(std::size_t{1} << 25, 8), Error);
    EXPECT_THROW(JointGrid::require_indexable(std::size_t{1} << 31, 1), Error);
}

} // namespace
} // namespace lumisweep
