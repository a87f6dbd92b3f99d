#include "efficiency.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <tbb/task_arena.h>

#include "lumisweep/backends/cpu/cpu_backend.h"
#include "lumisweep/base/stopwatch.h"
#include "references.h"

namespace lumisweep::bench {
namespace {

double luminance_at(std::span<const float> color, std::size_t pixel)
{
    return luminance(color[3 * pixel], color[3 * pixel + 1], color[3 * pixel + 2]);
}

double mean_luminance(std::span<const float> color)
{
    double sum = 0.0;
    for (std::size_t p = 0; p < color.size() / 3; ++p)
        sum += luminance_at(color, p);
    return sum / static_cast<double>(color.size() / 3);
}

double squared_error(std::span<const double> sums, int samples, const Reference& reference)
{
    double sum = 0.0;
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const double d = sums[i] / samples - static_cast<double>(reference.color[i]);
        sum += d * d;
    }
    return sum / static_cast<double>(sums.size()) - reference.own_mse;
}

/// Collects the samples of every pass as what they add to the sums.
class SingleSamples {
public:
    explicit SingleSamples(const Reference& reference) : reference_(reference)
    {
        double sum = 0.0;
        std::vector<std::size_t> covered;
        for (std::size_t p = 0; p < reference.covered.size(); ++p)
            if (reference.covered[p] >= 0.5F) {
                covered.push_back(p);
                sum += luminance_at(reference.color, p);
            }
        for (const std::size_t p : covered)
            if (luminance_at(reference.color, p) * 20.0 * static_cast<double>(covered.size()) >= sum)
                pixels_.push_back(p);
    }

    void start() { before_.assign(reference_.color.size(), 0.0); }
    void add(std::span<const double> sums)
    {
        double mean = 0.0;
        for (std::size_t p = 0; p < sums.size() / 3; ++p)
            mean += luminance_of(sums, p);
        image_means_.push_back(mean / (static_cast<double>(sums.size()) / 3.0));
        for (const std::size_t p : pixels_) {
            const double relative = luminance_of(sums, p) / luminance_at(reference_.color, p);
            relative_.push_back(static_cast<float>(relative));
            const double square = (relative - 1.0) * (relative - 1.0);
            second_ += square;
            fourth_ += square * square;
        }
        std::copy(sums.begin(), sums.end(), before_.begin());
    }
    /// Adds what it has seen to the result.
    void finish(MeasuredNoise& result) const
    {
        const MeanAndError mean = mean_and_error(image_means_);
        const double error = std::hypot(mean.error, reference_.mean_error);
        result.bias_in_errors = error > 0.0 ? (mean.mean - mean_luminance(reference_.color)) / error : 0.0;
        if (relative_.empty() || second_ == 0.0)
            return;
        const auto count = static_cast<double>(relative_.size());
        std::vector<float> ordered = relative_;
        const auto at = ordered.begin() + static_cast<std::ptrdiff_t>(0.9999 * (count - 1.0));
        std::nth_element(ordered.begin(), at, ordered.end());
        result.percentile_9999 = static_cast<double>(*at);
        result.kurtosis = fourth_ * count / (second_ * second_);
    }

private:
    double luminance_of(std::span<const double> sums, std::size_t p) const
    {
        return luminance(sums[3 * p] - before_[3 * p], sums[3 * p + 1] - before_[3 * p + 1],
                         sums[3 * p + 2] - before_[3 * p + 2]);
    }

    const Reference& reference_;
    std::vector<std::size_t> pixels_;
    std::vector<double> before_, image_means_;
    std::vector<float> relative_;
    double second_ = 0.0, fourth_ = 0.0;
};

/// Adds the processor time of work() on this thread, which does all of it, to `seconds`.
template <class Work>
void timed_alone(double& seconds, Work&& work)
{
    tbb::task_arena(1).execute([&] {
        const ProcessorStopwatch watch(seconds);
        work();
    });
}

double faster_half(std::vector<double> seconds)
{
    std::sort(seconds.begin(), seconds.end());
    seconds.resize((seconds.size() + 1) / 2);
    return mean_and_error(seconds).mean;
}

} // namespace

Reference make_reference(const SessionInput& input, int samples, std::uint64_t seed)
{
    Reference reference;
    reference.width = input.image.width;
    reference.height = input.image.height;
    const std::size_t pixels =
        static_cast<std::size_t>(input.image.width) * static_cast<std::size_t>(input.image.height);
    reference.color.resize(3 * pixels);
    reference.albedo.resize(3 * pixels);
    reference.covered.resize(pixels);
    Session session(input, make_cpu_backend());
    const int half = std::max(samples / 2, 1);
    std::vector<double> first(3 * pixels);
    double variance_of_sum = 0.0;
    for (int part = 0; part < 2; ++part) {
        RenderSettings render = input.render;
        render.seed = seed + static_cast<std::uint64_t>(part);
        session.set_render(render);
        for (int i = 0; i < half; ++i)
            session.render_pass();
        const Film& film = session.film();
        for (std::size_t i = 0; i < 3 * pixels; ++i) {
            const double value = film.color_sum()[i] / half;
            if (part == 0)
                first[i] = value;
            else
                reference.own_mse += 0.25 * (value - first[i]) * (value - first[i]);
            reference.color[i] += static_cast<float>(0.5 * value);
        }
        for (std::size_t p = 0; p < pixels; ++p) {
            const float* features = film.features().data() + feature_count * p;
            for (std::size_t c = 0; c < 3; ++c)
                reference.albedo[3 * p + c] += 0.5F * features[c] / static_cast<float>(half);
            reference.covered[p] += 0.5F * features[7] / static_cast<float>(half);
            // Channels of a sample are almost perfectly correlated: standard deviations add.
            const auto deviation = [&](std::size_t c) { return std::sqrt(film.unbiased_variance_of_mean(3 * p + c)); };
            const double d = luminance(deviation(0), deviation(1), deviation(2));
            variance_of_sum += 0.25 * d * d;
        }
    }
    reference.own_mse /= static_cast<double>(3 * pixels);
    reference.mean_error = std::sqrt(variance_of_sum) / static_cast<double>(pixels);
    return reference;
}

double visible_light(const Reference& reference, const Environment& light)
{
    const auto side = static_cast<std::size_t>(light.resolution());
    const float* radiance = light.view().radiance;
    double mean[3] = {};
    for (std::size_t i = 0; i < 3 * side * side; ++i)
        mean[i % 3] += radiance[i] / static_cast<double>(side * side);
    double without_shadows = 0.0, arrived = 0.0;
    for (std::size_t p = 0; p < reference.covered.size(); ++p) {
        const float* albedo = reference.albedo.data() + 3 * p;
        without_shadows += luminance(albedo[0] * mean[0], albedo[1] * mean[1], albedo[2] * mean[2]);
        arrived += luminance_at(reference.color, p);
    }
    return without_shadows > 0.0 ? arrived / without_shadows : 0.0;
}

struct NoiseMeasurement::State {
    const Reference& reference;
    std::vector<int> sample_counts;
    SingleSamples single;
    std::unique_ptr<Estimator> estimator;
    double preparation_s = 0.0, sample_s = 1e30;
    std::vector<std::vector<double>> errors;
};

NoiseMeasurement::NoiseMeasurement(const std::function<std::unique_ptr<Estimator>()>& make, const Reference& reference,
                                   std::vector<int> sample_counts)
    : state_(new State{reference, std::move(sample_counts), SingleSamples(reference), nullptr, 0.0, 1e30, {}})
{
    state_->errors.resize(state_->sample_counts.size());
    timed_alone(state_->preparation_s, [&] { state_->estimator = make(); });
}

NoiseMeasurement::~NoiseMeasurement() = default;
NoiseMeasurement::NoiseMeasurement(NoiseMeasurement&&) noexcept = default;

void NoiseMeasurement::render(std::uint64_t seed)
{
    State& s = *state_;
    std::vector<double> pass_s;
    s.estimator->start(seed);
    s.single.start();
    for (int samples = 1; samples <= s.sample_counts.back(); ++samples) {
        timed_alone(pass_s.emplace_back(0.0), [&] { s.estimator->pass(); });
        s.single.add(s.estimator->sums());
        const auto wanted = std::find(s.sample_counts.begin(), s.sample_counts.end(), samples);
        if (wanted != s.sample_counts.end())
            s.errors[static_cast<std::size_t>(wanted - s.sample_counts.begin())].push_back(
                squared_error(s.estimator->sums(), samples, s.reference));
    }
    s.sample_s = std::min(s.sample_s, faster_half(std::move(pass_s)));
}

MeasuredNoise NoiseMeasurement::result() const
{
    MeasuredNoise result;
    result.preparation_s = state_->preparation_s;
    result.sample_s = state_->sample_s;
    for (const std::vector<double>& of_count : state_->errors) {
        const MeanAndError mean = mean_and_error(of_count);
        result.mse.push_back(mean.mean);
        result.mse_error.push_back(mean.error);
    }
    state_->single.finish(result);
    return result;
}

} // namespace lumisweep::bench
