// Hypothesis tests: p-values, the Šidák correction, and Pearson's chi-square with pooling of rare classes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

namespace lumisweep::test {

/// The regularised upper incomplete gamma function Q(a, x): series below a + 1, Lentz's continued fraction above
/// (Abramowitz and Stegun 6.5.29 and 6.5.31).
inline double gamma_q(double a, double x)
{
    if (x <= 0.0)
        return 1.0;
    const double factor = std::exp(-x + a * std::log(x) - std::lgamma(a));
    if (x < a + 1.0) {
        double term = 1.0 / a, sum = term;
        for (double n = a + 1.0; term > sum * 1e-16; n += 1.0) {
            term *= x / n;
            sum += term;
        }
        return 1.0 - sum * factor;
    }
    constexpr double tiny = 1e-300;
    double b = x + 1.0 - a, c = 1.0 / tiny, d = 1.0 / b, h = d;
    for (int i = 1; i < 100000; ++i) {
        const double an = -i * (i - a);
        b += 2.0;
        d = an * d + b;
        d = 1.0 / (std::fabs(d) < tiny ? tiny : d);
        c = b + an / c;
        c = std::fabs(c) < tiny ? tiny : c;
        h *= d * c;
        if (std::fabs(d * c - 1.0) < 1e-15)
            break;
    }
    return factor * h;
}

/// P(χ² ≥ statistic) for the given degrees of freedom.
inline double chi_square_p(double statistic, int degrees_of_freedom)
{
    return gamma_q(0.5 * degrees_of_freedom, 0.5 * statistic);
}

/// P(|Z| ≥ |z|) for a standard normal Z.
inline double normal_p(double z) { return std::erfc(std::fabs(z) / std::sqrt(2.0)); }

/// The p-value below which one of `tests` independent tests is significant when all of them together shall reject a
/// true hypothesis with probability `significance`.
inline double sidak(double significance, double tests) { return -std::expm1(std::log1p(-significance) / tests); }

struct ChiSquare {
    double statistic = 0.0;
    int degrees_of_freedom = 0;
    double p = 1.0;
    bool impossible = false; ///< something of expectation 0 was observed
};

/// Pearson's test. Classes that expect fewer than `pool_below` are pooled, smallest first.
inline ChiSquare chi_square(const std::vector<std::uint64_t>& observed, const std::vector<double>& expected,
                            double pool_below = 8.0)
{
    ChiSquare result;
    std::vector<std::size_t> order(observed.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return expected[a] < expected[b]; });
    double pooled_expected = 0.0, pooled_observed = 0.0;
    int classes = 0;
    const auto take = [&](double o, double e) {
        result.statistic += (o - e) * (o - e) / e;
        ++classes;
    };
    for (const std::size_t i : order) {
        const double o = static_cast<double>(observed[i]);
        if (expected[i] <= 0.0) {
            result.impossible = result.impossible || o > 0.0;
            continue;
        }
        pooled_expected += expected[i];
        pooled_observed += o;
        if (pooled_expected >= pool_below) {
            take(pooled_observed, pooled_expected);
            pooled_expected = pooled_observed = 0.0;
        }
    }
    if (pooled_expected > 1e-3)
        take(pooled_observed, pooled_expected);
    result.degrees_of_freedom = std::max(classes - 1, 0);
    result.p = result.impossible ? 0.0 : classes > 1 ? chi_square_p(result.statistic, classes - 1) : 1.0;
    return result;
}

/// Mean and variance of a stream of numbers (Welford 1962).
class Moments {
public:
    void add(double x)
    {
        n_ += 1.0;
        const double d = x - mean_;
        mean_ += d / n_;
        m2_ += d * (x - mean_);
    }
    double count() const { return n_; }
    double mean() const { return mean_; }
    double variance() const { return n_ > 1.0 ? m2_ / (n_ - 1.0) : std::numeric_limits<double>::infinity(); }
    double standard_error() const { return std::sqrt(variance() / n_); }

private:
    double n_ = 0.0, mean_ = 0.0, m2_ = 0.0;
};

/// Welch's test of two means, judged by the normal distribution: leave a margin where values are few.
inline double p_of_means(const Moments& a, const Moments& b)
{
    const double error = std::hypot(a.standard_error(), b.standard_error()), difference = a.mean() - b.mean();
    return error > 0.0 ? normal_p(difference / error) : difference == 0.0 ? 1.0 : 0.0;
}

} // namespace lumisweep::test
