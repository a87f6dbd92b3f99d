// Walking through majorant cells: a flight uses up the optical depth of the majorants along its ray, no more and no
// less, however empty space is skipped. The oracle cuts rays at every cell's sides in double precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "lumisweep/render/tracking_stages.h"
#include "lumisweep/volume/majorant_grid.h"
#include "support/effort.h"

namespace lumisweep {
namespace {

struct Grids {
    ScalarGrid grid;
    MajorantGrid majorants;
    SceneView view;

    Grids(Vec3i size, int voxels, std::mt19937& random) : grid(VoxelType::u8, size, Affine3d{})
    {
        for (int i = 0; i < voxels; ++i)
            grid.voxels<std::uint8_t>()[random() % grid.voxel_count()] =
                static_cast<std::uint8_t>(101 + random() % 150);
        majorants = MajorantGrid(BoundsGrid(grid), TransferFunction({{100.0, 0.0}, {255.0, 2.0}}));
        view.size = size;
        view.majorants = majorants.view();
    }

    double majorant(const Vec3d& p_voxel) const
    {
        const auto cell = [](double p, int n) {
            return std::clamp(static_cast<int>((p + 0.5) / majorant_cell), 0, n - 1);
        };
        const MajorantView& m = view.majorants;
        return double(
            majorant_at<float>(m, {cell(p_voxel.x, m.size.x), cell(p_voxel.y, m.size.y), cell(p_voxel.z, m.size.z)})
                .value);
    }

    struct Exit {
        double t, speed; ///< voxels per unit of t across the side
    };
    /// Where a ray from within leaves the volume.
    Exit exit(const Vec3d& o, const Vec3d& d) const
    {
        Exit nearest{1e30, 0.0};
        for (int axis = 0; axis < 3; ++axis) {
            const double end = component(d, axis) > 0.0 ? component(view.size, axis) : 0.0;
            const double t = (end - component(o, axis)) / component(d, axis);
            if (t < nearest.t)
                nearest = {std::max(t, 0.0), std::fabs(component(d, axis))};
        }
        return nearest;
    }

    double optical_depth(const Vec3d& o, const Vec3d& d) const
    {
        const double end = exit(o, d).t;
        std::vector<double> cuts{0.0, end};
        for (int axis = 0; axis < 3; ++axis)
            for (int e = 0; e <= component(view.size, axis); ++e) {
                const double t = (majorant_cell * e - 0.5 - component(o, axis)) / component(d, axis);
                if (t > 0.0 && t < end)
                    cuts.push_back(t);
            }
        std::sort(cuts.begin(), cuts.end());
        double sum = 0.0;
        for (std::size_t i = 1; i < cuts.size(); ++i)
            sum += majorant(o + d * (0.5 * (cuts[i - 1] + cuts[i]))) * (cuts[i] - cuts[i - 1]);
        return sum;
    }
};

struct Walked {
    double optical_depth, t;
    int steps;
};

Walked walk_through(const SceneView& view, const Vec3f& origin, const Vec3f& direction)
{
    PathState<float> path{};
    path.origin = origin;
    path.direction = {stage::nonzero(direction.x), stage::nonzero(direction.y), stage::nonzero(direction.z)};
    const float much = 4096.0F;
    path.optical_depth = much;
    path.cell = stage::cell_at(view, path.origin);
    stage::Walk<float> walk = stage::begin_walk(view, path);
    for (int steps = 1;; ++steps) {
        const stage::Advanced<float> advanced = stage::advance(view, true, path, walk);
        if (advanced.left || advanced.candidate || steps == 100000)
            return {advanced.left ? double(much) - double(path.optical_depth) : -1.0, double(path.t), steps};
    }
}

TEST(Advance, UsesUpTheMajorantsAlongTheRay)
{
    std::mt19937 random(2024);
    std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
    for (const Vec3i& size : {Vec3i{64, 64, 64}, Vec3i{33, 70, 21}, Vec3i{120, 7, 64}, Vec3i{1, 40, 50}})
        for (const int voxels : {1, 8, 60, 4000}) {
            const Grids scene(size, voxels, random);
            for (int i = 0; i < test::effort(4000); ++i) {
                Vec3f o{(uniform(random) + 1.0F) * 0.5F * float(size.x),
                        (uniform(random) + 1.0F) * 0.5F * float(size.y),
                        (uniform(random) + 1.0F) * 0.5F * float(size.z)};
                Vec3f d{uniform(random), uniform(random), uniform(random)};
                if (i % 4 == 1) // along an axis, or nearly so, within a side between cells
                    (i % 8 == 1 ? d.x : d.y) = 0.0F, d.z *= 1e-3F;
                if (i % 3 == 1)
                    o.z = std::min(std::floor(o.z) + 0.5F, float(size.z));
                d = d * (1.0F / std::sqrt(dot(d, d)));
                const Vec3d exact{double(stage::nonzero(d.x)), double(stage::nonzero(d.y)),
                                  double(stage::nonzero(d.z))};
                const Walked walked = walk_through(scene.view, o, d);
                ASSERT_GE(walked.optical_depth, 0.0);
                const Grids::Exit end = scene.exit(to_double(o), exact);
                EXPECT_LE(std::fabs(walked.t - end.t) * end.speed, 1e-4);
                // A ray that lies within a side may take the cells on either side of it.
                const Vec3d shift{1e-4, 1e-4, 1e-4};
                const double a = scene.optical_depth(to_double(o), exact);
                const double b = scene.optical_depth(to_double(o) + shift, exact);
                const double c = scene.optical_depth(to_double(o) - shift, exact);
                const double low = std::min({a, b, c}), high = std::max({a, b, c});
                EXPECT_GE(walked.optical_depth, low - 5e-3 - 1e-4 * low) << i;
                EXPECT_LE(walked.optical_depth, high + 5e-3 + 1e-4 * high) << i;
            }
        }
}

// Through 500 voxels of nothing in a few steps; next to something, cell by cell.
TEST(Advance, SkipsEmptySpace)
{
    std::mt19937 random(3);
    const Grids empty({500, 500, 500}, 0, random);
    const Vec3f d{0.8F, 0.59F, 0.1077F};
    EXPECT_LE(walk_through(empty.view, {0.1F, 0.2F, 3.0F}, d).steps, 4);
    const Grids sparse({500, 500, 500}, 12, random);
    EXPECT_LE(walk_through(sparse.view, {0.1F, 0.2F, 3.0F}, d).steps, 60);
}

} // namespace
} // namespace lumisweep
