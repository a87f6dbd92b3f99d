// All strategies have the same mean, whatever the visibility grid holds: per image block, within their standard errors.
#include <gtest/gtest.h>

#include <random>

#include "support/effort.h"
#include "support/image_blocks.h"
#include "support/scenes.h"

namespace lumisweep {
namespace {

using namespace test;

/// Per block: mean over its pixels of the luminance and the standard error of that, from the spread over batches of
/// passes.
struct Blocks {
    test::Moments moments[image_blocks];
};

/// Each batch starts from a fresh film, so that batches are independent samples of the block means.
Blocks block_means(const SessionInput& input, int passes, const std::string& isa,
                   const VisibilityGrid* poison = nullptr)
{
    Session session(input, make_cpu_backend(isa));
    Blocks result;
    for (int b = 0; b < batches; ++b) {
        RenderSettings render = input.render;
        render.seed = input.render.seed * 1000 + static_cast<std::uint64_t>(b);
        session.set_render(render);
        if (poison != nullptr) {
            VisibilityGrid copy(input.volume->size(), input.visibility.cell, input.visibility.directions);
            for (int d = 0; d < copy.direction_count(); ++d)
                std::copy(poison->direction(d), poison->direction(d) + copy.cell_count(), copy.direction(d));
            session.replace_visibility(std::move(copy));
        }
        for (int p = 0; p < passes; ++p)
            session.render_pass();
        double sum[image_blocks] = {};
        for (int y = 0; y < image_side; ++y)
            for (int x = 0; x < image_side; ++x) {
                const double* c = session.film().color_sum().data() + 3 * (y * image_side + x);
                sum[block_of_pixel(x, y)] += luminance(c[0], c[1], c[2]);
            }
        for (int i = 0; i < image_blocks; ++i)
            result.moments[i].add(sum[i] / (double(pixels_of_block) * passes));
    }
    return result;
}

/// Of all blocks.
double smallest_p(const Blocks& a, const Blocks& b)
{
    double p = 1.0;
    for (int i = 0; i < image_blocks; ++i)
        p = std::min(p, test::p_of_means(a.moments[i], b.moments[i]));
    return p;
}

/// The relative standard error of a block, at worst: what says that the test would find a bias.
double power(const Blocks& a)
{
    double worst = 0.0;
    for (const test::Moments& m : a.moments)
        worst = std::max(worst, m.standard_error() / std::max(m.mean(), 1e-12));
    return worst;
}

struct Scene {
    const char* name;
    SessionInput input;
};

std::vector<Scene> scenes()
{
    std::vector<Scene> result;
    const Vec3i size{27, 30, 25};
    const Affine3d place = test::centered(size, {1.0, 1.1, 0.9});
    for (const char* light : {"constant", "sky"}) {
        SessionInput base;
        base.environment = light[0] == 'c' ? test::constant_light({1.0, 0.8, 0.6}) : test::sky_with_sun(64, 12.0);
        base.image = {image_side, image_side, false};
        base.camera.position = {25.0, -70.0, 20.0};
        base.camera.vertical_fov_deg = 22.0;
        SessionInput homogeneous = base, ct = base, smoke = base;
        homogeneous.volume = test::constant_grid(size, place);
        homogeneous.transfer_function = TransferFunction({{0.0, 0.1, {0.9, 0.9, 0.9}}});
        ct.volume = test::ct_like(size, place);
        ct.transfer_function = test::ct_transfer_function();
        smoke.volume = test::smoke_like(size, place);
        smoke.transfer_function = test::smoke_transfer_function();
        result.push_back({light[0] == 'c' ? "homogeneous, constant" : "homogeneous, sky", homogeneous});
        result.push_back({light[0] == 'c' ? "CT, constant" : "CT, sky", ct});
        result.push_back({light[0] == 'c' ? "smoke, constant" : "smoke, sky", smoke});
    }
    return result;
}

TEST(EqualMeans, AllStrategiesOnAllInstructionSets)
{
    const int passes = effort(20);
    const std::vector<Scene> all = scenes();
    const double tests =
        static_cast<double>(all.size() * std::size(test::all_strategies) * available_isas().size() * image_blocks);
    // Batches are few: the tails of Student's t with 46 degrees of freedom are heavier, hence the small significance.
    const double limit = test::sidak(0.0005, tests);
    std::uint64_t seed = 100;
    for (const Scene& scene : all) {
        SessionInput input = scene.input;
        input.render.strategy = Strategy::environment;
        input.render.seed = ++seed;
        const Blocks reference = block_means(input, 5 * passes, "auto");
        EXPECT_LT(power(reference), test::full_effort ? 0.005 : 0.02) << scene.name;
        for (const Strategy strategy : test::all_strategies) {
            for (const std::string& isa : available_isas()) {
                input.render.strategy = strategy;
                input.render.seed = ++seed;
                const Blocks blocks_here = block_means(input, passes, isa);
                EXPECT_GT(smallest_p(blocks_here, reference), limit)
                    << scene.name << ", " << name_of(strategy) << ", " << isa << ", seed " << seed;
            }
        }
    }
}

TEST(EqualMeans, PoisonedVisibility)
{
    const int passes = effort(24);
    const Vec3i size{27, 30, 25};
    const std::vector<Scene> all = scenes();
    std::uint64_t seed = 900;
    for (const std::size_t which : {std::size_t{4}, std::size_t{5}}) { // CT and smoke under the sky
        SessionInput input = all[which].input;
        input.visibility.epsilon = 0.05;
        input.render.strategy = Strategy::environment;
        input.render.seed = ++seed;
        const Blocks reference = block_means(input, 5 * passes, "auto");
        SessionInput other = all[9 - which].input;
        Session others(other, make_cpu_backend()), own(input, make_cpu_backend());
        own.set_render({Strategy::two_step, 0});
        own.prepare();
        others.prepare();
        std::mt19937 random(5);
        const auto poison = [&](auto&& value) {
            VisibilityGrid grid(size, input.visibility.cell, input.visibility.directions);
            for (int d = 0; d < grid.direction_count(); ++d)
                for (std::size_t c = 0; c < grid.cell_count(); ++c)
                    grid.direction(d)[c] = static_cast<std::uint8_t>(value(d, c));
            return grid;
        };
        const struct {
            const char* name;
            VisibilityGrid grid;
        } poisons[] = {
            {"zeros", poison([](int, std::size_t) { return 0; })},
            {"ones", poison([](int, std::size_t) { return 255; })},
            {"noise", poison([&](int, std::size_t) { return random() & 255U; })},
            {"another volume's", poison([&](int d, std::size_t c) { return others.visibility().direction(d)[c]; })},
            {"mirrored", poison([&](int d, std::size_t c) {
                 return own.visibility().direction(63 - d)[own.visibility().cell_count() - 1 - c];
             })},
        };
        const double limit = test::sidak(0.0005, 2.0 * 5.0 * 4.0 * image_blocks);
        for (const auto& p : poisons) {
            for (const Strategy strategy :
                 {Strategy::visibility, Strategy::combined, Strategy::two_step, Strategy::automatic}) {
                input.render.strategy = strategy;
                input.render.seed = ++seed;
                const Blocks poisoned = block_means(input, passes, "auto", &p.grid);
                EXPECT_GT(smallest_p(poisoned, reference), limit)
                    << all[which].name << ", " << p.name << ", " << name_of(strategy) << ", seed " << seed;
            }
        }
    }
}

} // namespace
} // namespace lumisweep
