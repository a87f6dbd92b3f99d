// The tests' own statistics, against known values.
#include <gtest/gtest.h>

#include "support/quadrature.h"
#include "support/statistics.h"

namespace lumisweep::test {
namespace {

TEST(Statistics, ChiSquareSurvival)
{
    // Two degrees of freedom: exp(−x/2); one: erfc(√(x/2)); four: exp(−x/2)(1 + x/2).
    for (const double x : {0.01, 0.5, 1.0, 3.84, 10.0, 50.0, 200.0}) {
        EXPECT_NEAR(chi_square_p(x, 2) / std::exp(-0.5 * x), 1.0, 1e-11);
        EXPECT_NEAR(chi_square_p(x, 1) / std::erfc(std::sqrt(0.5 * x)), 1.0, 1e-11);
        EXPECT_NEAR(chi_square_p(x, 4) / (std::exp(-0.5 * x) * (1.0 + 0.5 * x)), 1.0, 1e-11);
    }
    EXPECT_NEAR(chi_square_p(124.342, 100), 0.05, 1e-6); // tables
    EXPECT_NEAR(chi_square_p(1143.917, 1023), 0.0046, 1e-3);
}

TEST(Statistics, ChiSquareFindsWhatIsWrong)
{
    const std::vector<double> expected(10, 1000.0);
    EXPECT_GT(chi_square({1000, 990, 1010, 1020, 980, 1000, 1030, 970, 1000, 1000}, expected).p, 0.5);
    EXPECT_LT(chi_square({1200, 990, 1010, 1020, 980, 1000, 1030, 970, 900, 900}, expected).p, 1e-6);
    EXPECT_TRUE(chi_square({5, 1}, {5.0, 0.0}).impossible);
    EXPECT_EQ(chi_square({100, 6, 0, 6, 0}, {100.0, 3.0, 3.0, 3.0, 3.0}).degrees_of_freedom,
              1); // three make a class; the fourth goes with the large one
}

TEST(Statistics, SidakAndNormal)
{
    EXPECT_NEAR(normal_p(1.959963985), 0.05, 1e-9);
    EXPECT_NEAR(1.0 - std::pow(1.0 - sidak(0.01, 100), 100), 0.01, 1e-12);
}

TEST(Statistics, Quadrature)
{
    const GaussLegendre rule(8);
    EXPECT_NEAR(rule(0.0, 2.0, [](double x) { return std::pow(x, 15.0); }), std::pow(2.0, 16.0) / 16.0, 1e-8);
    EXPECT_NEAR(rule(-1.0, 3.0, [](double x) { return std::exp(x); }), std::exp(3.0) - std::exp(-1.0), 1e-10);
}

} // namespace
} // namespace lumisweep::test
