// The measure itself, on estimators whose noise is known.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <vector>

#include "efficiency.h"
#include "lumisweep/light/sky.h"
#include "reference_file.h"
#include "volumes.h"

namespace lumisweep::bench {
namespace {

constexpr int side = 64;
constexpr std::size_t values = 3 * side * side;

/// Every pixel is grey, truth + normal noise of the given deviation; with `rare`, noise that is rare + 1 with
/// probability 1 / (rare + 1) and 0 else, less 1.
class KnownNoise final : public Estimator {
public:
    KnownNoise(double truth, double deviation, double rare) : truth_(truth), deviation_(deviation), rare_(rare) {}
    void start(std::uint64_t seed) override
    {
        random_.seed(seed);
        sums_.assign(values, 0.0);
    }
    void pass() override
    {
        std::normal_distribution<double> normal;
        std::bernoulli_distribution seldom(1.0 / (rare_ + 1.0));
        for (std::size_t i = 0; i < values; i += 3) {
            const double noise = rare_ > 0.0 ? (seldom(random_) ? rare_ : -1.0) : normal(random_);
            for (std::size_t c = 0; c < 3; ++c)
                sums_[i + c] += truth_ + deviation_ * noise;
        }
    }
    std::span<const double> sums() const override { return sums_; }

private:
    double truth_, deviation_, rare_;
    std::mt19937_64 random_;
    std::vector<double> sums_;
};

/// The truth with noise of its own.
Reference reference_with_noise(double truth, double deviation)
{
    Reference reference;
    reference.width = reference.height = side;
    reference.color.resize(values);
    reference.albedo.assign(values, 0.5F);
    reference.covered.assign(values / 3, 1.0F);
    reference.own_mse = deviation * deviation;
    reference.mean_error = deviation / side;
    std::mt19937_64 random(99);
    std::normal_distribution<double> normal(truth, deviation);
    for (std::size_t i = 0; i < values; ++i)
        reference.color[i] = i % 3 == 0 ? static_cast<float>(normal(random)) : reference.color[i - 1];
    return reference;
}

MeasuredNoise measured(double truth, double deviation, double rare, const Reference& reference)
{
    NoiseMeasurement measurement([&] { return std::make_unique<KnownNoise>(truth, deviation, rare); }, reference,
                                 {4, 16});
    for (const std::uint64_t seed : {1U, 2U, 3U})
        measurement.render(seed);
    return measurement.result();
}

TEST(NoiseMeasurement, FindsKnownNoise)
{
    // The reference's own error is four times that of the images: without its subtraction all would be wrong.
    const Reference reference = reference_with_noise(2.0, 0.05);
    const MeasuredNoise noise = measured(2.0, 0.1, 0.0, reference);
    const double pixels = side * side;
    EXPECT_NEAR(noise.mse[0], 0.01 / 4,
                4.0 * std::hypot(0.01 / 4 * std::sqrt(2 / pixels / 3), 0.0025 * std::sqrt(2 / pixels)));
    EXPECT_NEAR(noise.mse[1], 0.01 / 16,
                4.0 * std::hypot(0.01 / 16 * std::sqrt(2 / pixels / 3), 0.0025 * std::sqrt(2 / pixels)));
    EXPECT_LT(std::fabs(noise.bias_in_errors), 4.0);
    EXPECT_GT(noise.sample_s, 0.0);
}

TEST(NoiseMeasurement, TellsFirefliesFromNormalNoise)
{
    const Reference reference = reference_with_noise(2.0, 1e-6);
    const MeasuredNoise normal = measured(2.0, 0.5, 0.0, reference);
    EXPECT_NEAR(normal.kurtosis, 3.0, 0.05);
    EXPECT_NEAR(normal.percentile_9999, 1.0 + 0.25 * 3.719, 0.05); // Φ(3.719) = 0.9999
    // Rare values a: E[x²] = a, E[x⁴] = (a⁴ + a) / (a + 1).
    const double a = 99.0;
    const MeasuredNoise rare = measured(2.0, 0.01, a, reference);
    EXPECT_NEAR(rare.kurtosis, (a * a * a * a + a) / (a + 1.0) / (a * a), 8.0);
    EXPECT_NEAR(rare.percentile_9999, 1.0 + 0.01 * a / 2.0, 1e-5);
}

TEST(NoiseMeasurement, FindsBias)
{
    const Reference reference = reference_with_noise(2.0, 1e-6);
    EXPECT_GT(measured(2.01, 0.1, 0.0, reference).bias_in_errors, 20.0);
}

TEST(Reference, KnowsItsErrorAndTheLightThatArrives)
{
    SessionInput input;
    Specimen specimen = fractal_shells({40, 40, 40}, 4.0);
    input.transfer_function = specimen.transfer_function;
    input.volume = std::make_shared<const ScalarGrid>(std::move(specimen.volume));
    input.environment = std::make_shared<const Environment>(environment_from_sky({}, 64));
    input.camera.position = {120.0, -420.0, 160.0};
    input.image = {32, 32, false};
    const Reference reference = make_reference(input, 64, 5), better = make_reference(input, 2048, 7);
    double squares = 0.0, mean = 0.0, better_mean = 0.0;
    for (std::size_t i = 0; i < reference.color.size(); ++i) {
        const double d = static_cast<double>(reference.color[i] - better.color[i]);
        squares += d * d / static_cast<double>(reference.color.size());
    }
    for (std::size_t p = 0; p < reference.covered.size(); ++p) {
        const auto grey = [&](const Reference& r) {
            return luminance(r.color[3 * p], r.color[3 * p + 1], r.color[3 * p + 2]) / 1024.0;
        };
        mean += grey(reference), better_mean += grey(better);
    }
    EXPECT_NEAR(squares / (reference.own_mse + better.own_mse), 1.0, 0.35);
    EXPECT_LT(std::fabs(mean - better_mean), 4.0 * std::hypot(reference.mean_error, better.mean_error));
    const double arrives = visible_light(better, *input.environment);
    EXPECT_GT(arrives, 0.05);
    EXPECT_LT(arrives, 0.95);

    // In a medium so thin that nothing is hidden, all of it arrives.
    SessionInput thin = input;
    thin.environment = std::make_shared<const Environment>(Environment::constant({2.0, 1.0, 0.5}));
    thin.transfer_function = TransferFunction({{0.0, 1e-6, {0.7, 0.6, 0.5}}});
    thin.render.strategy = Strategy::environment;
    thin.image = {16, 16, false};
    thin.camera.vertical_fov_deg = 10.0;
    EXPECT_NEAR(visible_light(make_reference(thin, 4000, 9), *thin.environment), 1.0, 0.001);

    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "lumisweep-reference.exr";
    write_reference(file, reference);
    const Reference read = read_reference(file);
    EXPECT_EQ(read.color, reference.color);
    EXPECT_EQ(read.albedo, reference.albedo);
    EXPECT_EQ(read.covered, reference.covered);
    EXPECT_EQ(read.own_mse, reference.own_mse);
    EXPECT_EQ(read.mean_error, reference.mean_error);
    std::filesystem::remove(file);
}

} // namespace
} // namespace lumisweep::bench
