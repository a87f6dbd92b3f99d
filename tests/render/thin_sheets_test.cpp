// Sheets one voxel thick in empty space, crossed at right and at grazing angles: what no step through cells or over
// empty space may miss. Interpolation makes each a hat of known integral.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "support/effort.h"
#include "support/scenes.h"

namespace lumisweep {
namespace {

using test::effort;

/// ∫ of the interpolated layers from a to b (voxels along their axis).
double layers_between(const std::vector<double>& layers, double a, double b)
{
    const auto value = [&](double z) {
        const double q = std::clamp(z - 0.5, 0.0, static_cast<double>(layers.size() - 1));
        const auto i = std::min(static_cast<std::size_t>(q), layers.size() - 2);
        return layers[i] + (layers[i + 1] - layers[i]) * (q - static_cast<double>(i));
    };
    double sum = 0.0, from = std::min(a, b);
    const double end = std::max(a, b);
    while (from < end) { // linear between voxel centres
        const double to = std::min(std::floor(from + 0.5) + 0.5, end);
        sum += 0.5 * (value(from) + value(to)) * (to - from);
        from = to;
    }
    return sum;
}

TEST(ThinSheets, TransmittanceAtAnyAngle)
{
    std::mt19937 random(99);
    std::uniform_real_distribution<double> uniform;
    for (int i = 0; i < 24; ++i) {
        const int axis = i % 3; // across the sheets
        Vec3i size{53, 61, 47};
        component(size, axis) = 150;
        std::vector<double> layers(150, 0.0);
        for (int sheets = 1 + i % 4; sheets > 0; --sheets)
            layers[10 + random() % 130] = 0.2 + uniform(random);
        SessionInput input;
        const Affine3d world_from_voxel = test::centered(size, {1.0, 1.0, 1.0});
        input.volume = test::make_grid<float>(VoxelType::f32, size, world_from_voxel, [&](int x, int y, int z) {
            return layers[static_cast<std::size_t>(component(Vec3i{x, y, z}, axis))];
        });
        // From a side to the opposite one along another axis, over few layers around a sheet or over all.
        const auto sheet = static_cast<double>(std::max_element(layers.begin(), layers.end()) - layers.begin());
        const double reach = i % 2 == 0 ? 70.0 : 0.7;
        const int across = (axis + 1 + i / 3 % 2) % 3, other = 3 - axis - across;
        Vec3d from, to;
        component(from, across) = 0.0, component(to, across) = component(size, across);
        component(from, other) = component(size, other) * uniform(random);
        component(to, other) = component(size, other) * uniform(random);
        component(from, axis) = std::clamp(sheet + 0.5 - reach, 1.0, 149.0);
        component(to, axis) = std::clamp(sheet + 0.5 + reach, 1.0, 149.0);
        const double length_voxel = length(to - from);
        const double cosine = std::fabs(component(to, axis) - component(from, axis)) / length_voxel;
        const double integral = layers_between(layers, component(from, axis), component(to, axis)) / cosine;
        ASSERT_GT(integral, 0.0);
        const double depth = 0.5 + uniform(random);
        input.transfer_function = TransferFunction(
            {{0.0, 0.0, {0.0, 0.0, 0.0}}, {1.0, 1.0, {0.0, 0.0, 0.0}}, {2.0, 2.0, {0.0, 0.0, 0.0}}}, depth / integral);
        input.environment = test::constant_light();
        input.image = {64, 64, true};
        const Vec3d p = world_from_voxel.point(from), q = world_from_voxel.point(to);
        input.camera = test::needle(p + (p - q) * 2.0, q);
        const auto session = test::rendered(input, effort(60));
        test::expect_close(test::overall(session->film()), std::exp(-depth), test::full_effort ? 1.2e-3 : 4e-3,
                           "sheets " + std::to_string(i));
    }
}

// An optical depth of 1e5 over the diagonal: one sheet is 1e3, and no light comes through; all does beside it, through
// tens of thousands of null collisions in the cells that hold both.
TEST(ThinSheets, OpaqueOnes)
{
    const Vec3i size{60, 60, 100};
    for (const int layer : {10, 50, 51, 99}) {
        SessionInput input;
        input.volume = test::make_grid<std::uint8_t>(VoxelType::u8, size, test::centered(size, {1.0, 1.0, 1.0}),
                                                     [&](int, int, int z) { return z == layer ? 200 : 0; });
        input.transfer_function = TransferFunction({{0.0, 0.0, {0.0, 0.0, 0.0}}, {200.0, 760.0, {0.0, 0.0, 0.0}}});
        input.environment = test::constant_light();
        input.image = {16, 16, true};
        const double z = layer - 49.5;
        input.camera = test::needle({-20.0, 3.0, z - 300.0}, {20.0, 3.0, z + 300.0});
        EXPECT_EQ(test::overall(test::rendered(input, 8)->film()).mean, 0.0);
        input.camera = test::needle({-100.0, 3.0, z - 1.01}, {100.0, 3.0, z - 1.01});
        EXPECT_EQ(test::overall(test::rendered(input, 8)->film()).mean, 1.0);
    }
}

} // namespace
} // namespace lumisweep
