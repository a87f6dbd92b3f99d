// Environments, visibility grids and positions that the tests of the direction strategies share, and the oracle of the
// density.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "lumisweep/sampling/direction_sampling.h"
#include "lumisweep/sampling/joint_grid.h"

namespace lumisweep::test {

inline constexpr Vec3i volume_size{13, 10, 21};
inline constexpr int voxels_per_cell = 4;
inline constexpr double epsilon = 0.01;
inline const Strategy strategies[] = {Strategy::uniform, Strategy::environment, Strategy::visibility,
                                      Strategy::combined, Strategy::two_step};

template <class Function>
Environment make_environment(int n, Function&& radiance)
{
    AlignedArray<float> texels(3 * static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
    for (std::size_t m = 0; m < texels.size() / 3; ++m) {
        const auto xy = morton_decode(static_cast<std::int32_t>(m));
        const Vec3d c = radiance(xy.x, xy.y);
        texels[3 * m] = static_cast<float>(c.x);
        texels[3 * m + 1] = static_cast<float>(c.y);
        texels[3 * m + 2] = static_cast<float>(c.z);
    }
    return Environment(n, std::move(texels));
}

struct NamedEnvironment {
    std::string name;
    Environment environment;
};

inline std::vector<NamedEnvironment> environments()
{
    constexpr int n = 32;
    std::mt19937 random(11);
    std::vector<NamedEnvironment> result;
    result.push_back({"smooth", make_environment(n, [](int x, int y) {
                          return Vec3d{1.0 + std::sin(0.2 * x), 1.1 + std::cos(0.15 * y), 0.5};
                      })});
    result.push_back({"one texel", make_environment(n, [](int x, int y) {
                          return x == 19 && y == 6 ? Vec3d{5.0, 4.0, 3.0} : Vec3d{0.0, 0.0, 0.0};
                      })});
    result.push_back({"sun and sky", make_environment(n, [](int x, int y) {
                          return x == 4 && y == 27 ? Vec3d{2000.0, 2000.0, 1500.0} : Vec3d{0.5, 0.7, 1.0 + 0.02 * y};
                      })});
    result.push_back({"random with black", make_environment(n, [&](int, int) {
                          const double v = static_cast<double>(random() % 1000) / 1000.0;
                          return v < 0.3 ? Vec3d{0.0, 0.0, 0.0} : Vec3d{v * v * v, v, 1.0 - v};
                      })});
    return result;
}

enum class Visible { nothing, everything, random };
inline constexpr Visible visibilities[] = {Visible::nothing, Visible::everything, Visible::random};
inline const char* name_of(Visible v)
{
    return v == Visible::nothing      ? "nothing visible"
           : v == Visible::everything ? "everything visible"
                                      : "random visibility";
}

inline VisibilityGrid make_visibility(Visible kind, int directions)
{
    VisibilityGrid grid(volume_size, voxels_per_cell, directions);
    std::mt19937 random(3);
    for (int d = 0; d < grid.direction_count(); ++d)
        for (std::size_t c = 0; c < grid.cell_count(); ++c) {
            const std::uint32_t r = random();
            grid.direction(d)[c] = kind == Visible::nothing      ? std::uint8_t{0}
                                   : kind == Visible::everything ? std::uint8_t{255}
                                   : (r & 256U) != 0             ? std::uint8_t{0}
                                                                 : static_cast<std::uint8_t>(r & 255U);
        }
    return grid;
}

/// Inside, at a cell's centre, at a border, outside of the outer cells' centres, in a corner.
inline const Vec3f positions[] = {{5.3F, 4.9F, 11.2F},
                                  {13.0F / 8.0F, 5.0F, 21.0F / 12.0F},
                                  {13.0F, 0.0F, 7.0F},
                                  {0.1F, 9.9F, 20.9F},
                                  {13.0F, 10.0F, 21.0F}};

/// The papers' density per unit square over all texels of the environment, in double and from the definitions: the
/// eight cells' products interpolated and normalised; two-step times the environment's share below the node.
inline std::vector<double> oracle_pdf(Strategy strategy, const Environment& environment,
                                      const VisibilityGrid& visibility, const Vec3f& p)
{
    const int n = environment.resolution(), d = visibility.directions_per_side(), below = n / d;
    std::vector<double> texel(static_cast<std::size_t>(n * n)), node(static_cast<std::size_t>(d * d)),
        pdf(texel.size());
    double mean = 0.0;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const float* rgb = environment.view().radiance + 3 * morton_encode(x, y);
            const double l = luminance(rgb[0], rgb[1], rgb[2]);
            texel[static_cast<std::size_t>(y * n + x)] = l;
            node[static_cast<std::size_t>(y / below * d + x / below)] += l / (below * below);
            mean += l / (double(n) * n);
        }
    std::vector<double> joint(node.size());
    double total = 0.0;
    for (int dy = 0; dy < d; ++dy)
        for (int dx = 0; dx < d; ++dx) {
            const std::uint8_t* v = visibility.direction(morton_encode(dx, dy));
            double sum = 0.0;
            for (int corner = 0; corner < 8; ++corner) {
                double w = 1.0;
                int cell[3];
                for (int axis = 0; axis < 3; ++axis) {
                    const int cells = component(visibility.cells(), axis);
                    const double q = std::clamp(double(component(p, axis)) * cells / component(volume_size, axis) - 0.5,
                                                0.0, cells - 1.0);
                    const int base = std::min(static_cast<int>(q), std::max(cells - 2, 0));
                    const bool second = ((corner >> axis) & 1) != 0;
                    w *= second ? q - base : 1.0 - (q - base);
                    cell[axis] = std::min(base + (second ? 1 : 0), cells - 1);
                }
                sum += w * (v[visibility.cell_index(cell[0], cell[1], cell[2])] / 255.0 + epsilon);
            }
            const auto i = static_cast<std::size_t>(dy * d + dx);
            joint[i] = sum * (strategy == Strategy::visibility ? 1.0 : node[i]);
            total += joint[i] / (double(d) * d);
        }
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const auto t = static_cast<std::size_t>(y * n + x), i = static_cast<std::size_t>(y / below * d + x / below);
            switch (strategy) {
            case Strategy::uniform: pdf[t] = 1.0; break;
            case Strategy::environment: pdf[t] = texel[t] / mean; break;
            case Strategy::two_step: pdf[t] = node[i] > 0.0 ? joint[i] / total * texel[t] / node[i] : 0.0; break;
            default: pdf[t] = joint[i] / total; break;
            }
        }
    return pdf;
}

/// What the kernels read, and what it points into.
struct Prepared {
    JointGrid joint;
    DirectionSamplingView view;
    Prepared(Strategy strategy, const Environment& environment, const VisibilityGrid& visibility)
        : joint(visibility, volume_size, environment,
                strategy == Strategy::visibility ? JointFactor::visibility_only : JointFactor::visibility_times_light,
                epsilon),
          view{strategy, environment.view(), joint.view()}
    {
    }
};

} // namespace lumisweep::test
