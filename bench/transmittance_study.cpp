#include "transmittance_study.h"

#include <algorithm>
#include <limits>

#include "lumisweep/backends/cpu/cpu_backend.h"
#include "lumisweep/base/stopwatch.h"
#include "lumisweep/render/backend.h"

namespace lumisweep::bench {
namespace {

/// Has a session prepare a scene, and takes it instead of rendering it. Valid while the session lives.
class SceneTaker final : public HostBackend {
public:
    explicit SceneTaker(SceneView& scene) : scene_(scene) {}
    std::string device() const override { return "none"; }
    std::string isa() const override { return "none"; }
    PassEnd render_pass(const SceneView& scene, const SampleView&, std::int64_t, const std::atomic<bool>*,
                        PassCounts&) override
    {
        scene_ = scene;
        return PassEnd::complete;
    }

private:
    SceneView& scene_;
};

constexpr int directions_per_collision = 2;

/// Shadow rays of some passes, two directions a collision; the rays of pass p are [begin[p], begin[p + 1]).
struct Passes {
    ShadowRays rays;
    std::vector<int> begin{0};
    double cpu_s = 0.0;
};

Passes collect(const TransmittanceKernels& kernels, const SceneView& scene, int count, int directions,
               std::uint64_t seed)
{
    const auto paths = static_cast<std::size_t>(scene.camera.width) * static_cast<std::size_t>(scene.camera.height);
    Passes passes{ShadowRays(paths * static_cast<std::size_t>(count * directions))};
    for (int p = 0; p < count; ++p) {
        CollectJob job{scene, pass_numbers(seed, p), directions, passes.rays.sink()};
        {
            const ProcessorStopwatch watch(passes.cpu_s);
            kernels.collect(job);
        }
        passes.rays.sink() = job.sink;
        passes.begin.push_back(job.sink.count);
    }
    return passes;
}

/// Sums over repetitions, per ray.
struct Sums {
    std::vector<double> first, second;
    int repetitions = 0;
    double best_s = std::numeric_limits<double>::infinity();
    TransmittanceCounts counts;

    explicit Sums(std::size_t rays) : first(rays), second(rays) {}
    void add(std::span<const float> estimates)
    {
        ++repetitions;
        for (std::size_t i = 0; i < first.size(); ++i) {
            const double t = static_cast<double>(estimates[i]);
            first[i] += t;
            second[i] += t * t;
        }
    }
};

/// Mean of weight · T over the shadow rays of the image, and of each pixel; a pixel's is at least a tenth of the
/// image's, which is where few of its rays were seen.
struct Contributions {
    double image = 0.0;
    std::vector<double> pixel;
};

class Study {
public:
    Study(const SceneView& scene, const CellBounds& bounds, const StudySize& size)
        : kernels_(transmittance_kernels().front()), scene_(scene), bounds_(bounds), size_(size),
          passes_(collect(kernels_, scene, size.passes, directions_per_collision, 0)),
          out_(static_cast<std::size_t>(passes_.rays.sink().count) + 16), combs_(out_.size() * (largest_order + 1))
    {
    }

    StudyResult run()
    {
        StudyResult result;
        time_collisions(result);
        const Contributions contributions = pilot();
        const auto& cases = estimator_cases();
        std::vector<Sums> sums;
        std::vector<std::vector<float>> thresholds;
        for (const EstimatorCase& c : cases) {
            sums.emplace_back(static_cast<std::size_t>(rays_of(c)));
            thresholds.push_back(thresholds_of(c, passes_, contributions));
        }
        // Interleaved, so that other load meets all of them.
        for (int repetition = 0; repetition < size_.repetitions; ++repetition)
            for (std::size_t e = 0; e < cases.size(); ++e)
                sums[e].add(estimate(passes_, cases[e], thresholds[e], repetition, rays_of(cases[e]), sums[e]));
        evaluate(sums, result);
        return result;
    }

private:
    /// Marching takes as long as thousands of lookups in opaque media: one pass's rays tell enough.
    int rays_of(const EstimatorCase& c) const
    {
        const bool marches = c.method == Transmittance::march || c.method == Transmittance::bounded_march;
        return marches ? passes_.begin[1] : passes_.rays.sink().count;
    }

    double paths() const { return static_cast<double>(scene_.camera.width) * scene_.camera.height; }

    void time_collisions(StudyResult& result) const
    {
        double one_s = std::numeric_limits<double>::infinity(), two_s = one_s;
        int rays = 0;
        for (int i = 0; i < size_.repetitions; ++i) {
            const Passes one = collect(kernels_, scene_, 1, 1, 1), two = collect(kernels_, scene_, 1, 2, 1);
            one_s = std::min(one_s, one.cpu_s);
            two_s = std::min(two_s, two.cpu_s);
            rays = one.rays.sink().count;
        }
        result.direction_s = std::max(two_s - one_s, 0.0) / std::max(rays, 1);
        result.camera_s = (one_s - std::max(two_s - one_s, 0.0)) / paths();
        result.rays_per_path = rays / paths();
    }

    std::span<const float> estimate(const Passes& passes, const EstimatorCase& c, const std::vector<float>& thresholds,
                                    int repetition, int rays, Sums& sums)
    {
        std::fill(out_.begin(), out_.end(), 0.0F);
        TransmittanceJob job;
        job.scene = scene_;
        job.bounds = bounds_.view(c.control);
        job.rays = passes.rays.view();
        job.rays.count = rays;
        job.method = c.method;
        job.threshold = thresholds.data();
        job.repetition = repetition;
        job.estimates = out_.data();
        job.combs = combs_.data();
        double cpu_s = 0.0;
        {
            const ProcessorStopwatch watch(cpu_s);
            kernels_.estimate(job);
        }
        sums.best_s = std::min(sums.best_s, cpu_s);
        sums.counts = job.counts;
        return {out_.data(), static_cast<std::size_t>(rays)};
    }

    /// From passes of their own: what a renderer could know before it starts.
    Contributions pilot()
    {
        const Passes passes = collect(kernels_, scene_, size_.passes, directions_per_collision, 2);
        const ShadowSink& rays = passes.rays.sink();
        out_.resize(std::max(out_.size(), static_cast<std::size_t>(rays.count) + 16));
        combs_.resize(out_.size() * (largest_order + 1));
        Sums sums(static_cast<std::size_t>(rays.count));
        const std::vector<float> threshold(out_.size(), 0.1F);
        sums.add(estimate(passes, estimator_cases().front(), threshold, 0, rays.count, sums));
        Contributions c;
        c.pixel.resize(static_cast<std::size_t>(paths()));
        std::vector<int> count(c.pixel.size());
        for (int i = 0; i < rays.count; ++i) {
            const double x = static_cast<double>(rays.weight[i]) * sums.first[static_cast<std::size_t>(i)];
            c.image += x;
            c.pixel[static_cast<std::size_t>(rays.pixel[i])] += x;
            ++count[static_cast<std::size_t>(rays.pixel[i])];
        }
        c.image /= std::max(rays.count, 1);
        for (std::size_t p = 0; p < c.pixel.size(); ++p)
            c.pixel[p] = std::max(c.pixel[p] / std::max(count[p], 1), 0.1 * c.image);
        return c;
    }

    std::vector<float> thresholds_of(const EstimatorCase& c, const Passes& passes,
                                     const Contributions& contributions) const
    {
        std::vector<float> thresholds(out_.size(), c.threshold);
        if (c.roulette == Roulette::transmittance)
            return thresholds;
        const ShadowSink& rays = passes.rays.sink();
        for (int i = 0; i < rays.count; ++i) {
            const double mean = c.roulette == Roulette::against_image
                                    ? contributions.image
                                    : contributions.pixel[static_cast<std::size_t>(rays.pixel[i])];
            thresholds[static_cast<std::size_t>(i)] *=
                static_cast<float>(mean / std::max(static_cast<double>(rays.weight[i]), 1e-30));
        }
        return thresholds;
    }

    /// E[x] of two shadow rays of one collision multiplied, and of two collisions of one pixel, per camera ray.
    struct Products {
        double same_collision = 0.0, same_pixel = 0.0;
    };
    Products products(const std::vector<double>& mean_t) const
    {
        const ShadowSink& rays = passes_.rays.sink();
        Products result;
        const auto pixels = static_cast<std::size_t>(paths());
        std::vector<double> sum(pixels), squares(pixels), pass_sum(pixels), by_collision;
        for (int p = 0; p < size_.passes; ++p) {
            std::fill(pass_sum.begin(), pass_sum.end(), 0.0);
            for (int i = passes_.begin[static_cast<std::size_t>(p)]; i < passes_.begin[static_cast<std::size_t>(p) + 1];
                 ++i) {
                const double x = static_cast<double>(rays.weight[i]) * mean_t[static_cast<std::size_t>(i)];
                pass_sum[static_cast<std::size_t>(rays.pixel[i])] += x / directions_per_collision;
            }
            for (std::size_t i = 0; i < pixels; ++i) {
                sum[i] += pass_sum[i];
                squares[i] += pass_sum[i] * pass_sum[i];
            }
        }
        for (std::size_t i = 0; i < pixels; ++i)
            result.same_pixel += (sum[i] * sum[i] - squares[i]) / (size_.passes * (size_.passes - 1.0));
        result.same_pixel /= paths();
        // The second of two directions that both bring light follows at most one vector behind the first.
        std::vector<double> first(static_cast<std::size_t>(rays.collisions), -1.0);
        for (int i = 0; i < rays.count; ++i) {
            const double x = static_cast<double>(rays.weight[i]) * mean_t[static_cast<std::size_t>(i)];
            double& other = first[static_cast<std::size_t>(rays.collision[i])];
            if (other < 0.0)
                other = x;
            else
                result.same_collision += x * other;
        }
        result.same_collision /= paths() * size_.passes;
        return result;
    }

    void evaluate(const std::vector<Sums>& sums, StudyResult& result) const
    {
        const ShadowSink& rays = passes_.rays.sink();
        // All that saw every ray together estimate T best.
        const auto count = static_cast<std::size_t>(rays.count);
        std::vector<double> mean_t(count);
        double estimates = 0.0;
        for (const Sums& s : sums)
            if (s.first.size() == count) {
                for (std::size_t i = 0; i < count; ++i)
                    mean_t[i] += s.first[i];
                estimates += s.repetitions;
            }
        for (double& t : mean_t) {
            t /= estimates;
            result.mean_transmittance += t / static_cast<double>(count);
        }
        const Products product = products(mean_t);
        result.background_variance = product.same_collision - product.same_pixel;
        const auto square_of = [&](const Sums& s, std::size_t n) {
            double square = 0.0;
            for (std::size_t i = 0; i < n; ++i) {
                const double w = static_cast<double>(rays.weight[i]);
                square += w * w * s.second[i] / s.repetitions;
            }
            return square / directions_per_collision;
        };
        const double samples = paths() * size_.passes;
        const double base_square = square_of(sums.front(), count) / samples;
        for (const Sums& s : sums) {
            EstimatorResult e;
            const std::size_t n = s.first.size();
            const auto rays_seen = static_cast<double>(n);
            e.ray_s = s.best_s / rays_seen;
            e.cells = static_cast<double>(s.counts.cells) / rays_seen;
            e.lookups = static_cast<double>(s.counts.lookups) / rays_seen;
            for (std::size_t i = 0; i < n; ++i) {
                const double w = static_cast<double>(rays.weight[i]), r = s.repetitions;
                const double variance = std::max(s.second[i] - s.first[i] * s.first[i] / r, 0.0) / (r - 1.0);
                e.mean += w * s.first[i] / r / rays_seen;
                e.variance += variance / rays_seen;
                e.weighted_variance += w * w * variance / rays_seen;
            }
            // Against the first estimator on the same rays, so that few rays do.
            const double part = samples * rays_seen / static_cast<double>(count);
            const double square = base_square + (square_of(s, n) - square_of(sums.front(), n)) / part;
            for (int k = 0; k < 3; ++k) {
                const double directions = 1 << k;
                e.image_variance[k] = (square - product.same_collision) / directions + result.background_variance;
                e.image_s[k] = result.camera_s + directions * result.rays_per_path * (result.direction_s + e.ray_s);
            }
            result.estimators.push_back(e);
        }
    }

    const TransmittanceKernels& kernels_;
    SceneView scene_;
    const CellBounds& bounds_;
    StudySize size_;
    Passes passes_;
    std::vector<float> out_, combs_;
};

} // namespace

const std::vector<EstimatorCase>& estimator_cases()
{
    static const std::vector<EstimatorCase> cases{
        {"ratio:0.1", Transmittance::ratio, 0.1F},
        {"delta", Transmittance::delta, 1.0F},
        {"ratio:none", Transmittance::ratio, 0.0F},
        {"ratio:0.03", Transmittance::ratio, 0.03F},
        {"ratio:0.25", Transmittance::ratio, 0.25F},
        {"ratio:0.5", Transmittance::ratio, 0.5F},
        {"ratio:1", Transmittance::ratio, 1.0F},
        {"ratio:image:0.1", Transmittance::ratio, 0.1F, Roulette::against_image},
        {"ratio:image:0.3", Transmittance::ratio, 0.3F, Roulette::against_image},
        {"ratio:image:1", Transmittance::ratio, 1.0F, Roulette::against_image},
        {"ratio:pixel:0.1", Transmittance::ratio, 0.1F, Roulette::against_pixel},
        {"ratio:pixel:0.3", Transmittance::ratio, 0.3F, Roulette::against_pixel},
        {"ratio:pixel:1", Transmittance::ratio, 1.0F, Roulette::against_pixel},
        {"residual:none", Transmittance::residual, 0.0F},
        {"residual:0.1", Transmittance::residual, 0.1F},
        {"residual:0.5", Transmittance::residual, 0.5F},
        {"residual:1", Transmittance::residual, 1.0F},
        {"centred:0.1", Transmittance::residual, 0.1F, Roulette::transmittance, Control::centred},
        {"centred:0.25", Transmittance::residual, 0.25F, Roulette::transmittance, Control::centred},
        {"march", Transmittance::march, 0.0F},
        {"march:bounded:0.1", Transmittance::bounded_march, 0.1F},
        {"march:bounded:1", Transmittance::bounded_march, 1.0F},
    };
    return cases;
}

StudyResult study_transmittance(SessionInput input, const StudySize& size)
{
    input.image = {size.image, size.image, false};
    const CellBounds bounds(*input.volume, input.transfer_function);
    SceneView scene;
    Session session(std::move(input), std::make_shared<SceneTaker>(scene));
    session.render_pass();
    return Study(scene, bounds, size).run();
}

} // namespace lumisweep::bench
