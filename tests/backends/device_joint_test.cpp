// The joint grid on the device against the host's, to the bit; light on the device.
#include "lumisweep/backends/cuda/device_joint.h"

#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "lumisweep/backends/cuda/device_environment.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

VisibilityGrid random_visibility(Vec3i cells, int directions)
{
    VisibilityGrid grid(cells, 1, directions);
    std::mt19937 random(static_cast<unsigned>(directions));
    for (int d = 0; d < grid.direction_count(); ++d)
        for (std::size_t c = 0; c < grid.cell_count(); ++c)
            grid.direction(d)[c] = static_cast<std::uint8_t>(random() & 255U);
    return grid;
}

Environment random_light(int n)
{
    AlignedArray<float> texels(static_cast<std::size_t>(3 * n * n));
    std::mt19937 random(5);
    for (float& channel : texels)
        channel = std::uniform_real_distribution<float>(0.0F, 9.0F)(random);
    return Environment(n, std::move(texels));
}

/// From the device, which holds `count` of them there.
std::vector<float> downloaded(const float* from, std::size_t count, const Stream& stream)
{
    std::vector<float> numbers(count);
    copy_to_host(numbers.data(), from, count * sizeof(float), stream);
    stream.wait();
    return numbers;
}

bool same(const float* expected, const std::vector<float>& numbers)
{
    return numbers.empty() || std::memcmp(expected, numbers.data(), numbers.size() * sizeof(float)) == 0;
}

TEST(DeviceJointTest, SameAsOnTheHost)
{
    const Stream stream;
    const Environment light = random_light(32);
    DeviceVisibility on_device;
    DeviceJoint joint;
    for (const int directions : {8, 1, 2, 4, 16, 32})
        for (const Vec3i cells : {Vec3i{1, 1, 1}, {13, 10, 9}, {64, 8, 1}, {9, 67, 3}}) {
            const VisibilityGrid visibility = random_visibility(cells, directions);
            const Vec3i volume_size{3 * cells.x, 3 * cells.y - 1, cells.z};
            on_device.upload(visibility, stream);
            for (const JointFactor factor : {JointFactor::visibility_only, JointFactor::visibility_times_light}) {
                const JointGrid grid(visibility, volume_size, light, factor, 0.1);
                joint.build(on_device, volume_size, light, factor, 0.1, stream);
                const JointView expected = grid.view(), view = joint.view();
                ASSERT_EQ(view.node_count, expected.node_count);
                EXPECT_EQ(view.levels, expected.levels);
                EXPECT_EQ(view.cells, expected.cells);
                EXPECT_EQ(view.cells_per_voxel, expected.cells_per_voxel);
                const std::size_t count = visibility.cell_count();
                EXPECT_TRUE(same(expected.root, downloaded(view.root, count, stream))) << directions << ' ' << count;
                EXPECT_TRUE(same(expected.nodes,
                                 downloaded(view.nodes, count * static_cast<std::size_t>(view.node_count), stream)))
                    << directions << ' ' << count;
            }
        }
}

TEST(DeviceEnvironmentTest, HoldsItsLight)
{
    const Stream stream;
    for (const int n : {1, 16}) {
        const Environment light = random_light(n);
        DeviceEnvironment on_device;
        on_device.upload(light, stream);
        const EnvironmentView expected = light.view(), view = on_device.view();
        const std::size_t texels = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
        EXPECT_EQ(view.levels, expected.levels);
        EXPECT_EQ(on_device.bytes(), light.bytes());
        EXPECT_TRUE(same(expected.radiance, downloaded(view.radiance, 3 * texels, stream)));
        EXPECT_TRUE(same(expected.luminance, downloaded(view.luminance, (4 * texels - 1) / 3, stream)));
    }
}

} // namespace
} // namespace lumisweep::LUMISWEEP_CUDA
