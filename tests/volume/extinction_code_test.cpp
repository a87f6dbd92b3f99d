// Codes of extinction.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "lumisweep/volume/extinction_code_steps.h"

namespace lumisweep {
namespace {

TEST(ExtinctionCode, IsTheLowestThatBounds)
{
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform;
    for (int i = 0; i < 200000; ++i) {
        const float largest =
            largest_majorant(static_cast<float>(std::exp2(200.0 * uniform(random) - 100.0) * (1.0 + uniform(random))));
        const double most = largest;
        const double anywhere = most * std::exp2(-18.0 * uniform(random));
        // A code's majorant itself, and numbers next to it.
        const double at = majorant_of_code<float>(first_majorant_code + static_cast<int>(random() % 224), largest);
        for (const double extinction : {anywhere, at, std::nextafter(at, 0.0), std::nextafter(at, most), most}) {
            const int code = code_of_extinction(extinction, largest);
            ASSERT_GE(code, first_majorant_code);
            ASSERT_GE(static_cast<double>(majorant_of_code<float>(code, largest)), extinction);
            if (code > first_majorant_code) {
                ASSERT_LT(static_cast<double>(majorant_of_code<float>(code - 1, largest)), extinction);
            }
        }
    }
    EXPECT_EQ(code_of_extinction(0.0, 1.0F), 0);
    EXPECT_EQ(code_of_extinction(1e-300, 1e30F), first_majorant_code);
}

TEST(ExtinctionCode, StepsAreItsMajorant)
{
    EXPECT_EQ(majorant_steps(0), 0U);
    EXPECT_EQ(majorant_steps(last_majorant_code) * majorant_step, 1.0);
    for (int code = first_majorant_code; code <= last_majorant_code; ++code)
        EXPECT_EQ(majorant_steps(code) * majorant_step, static_cast<double>(majorant_of_code<float>(code, 1.0F)));
}

TEST(ExtinctionCode, TheLargestMajorantIsTheNextNumber)
{
    for (const float entry : {1e-30F, 0.1F, 1.0F, std::nextafter(2.0F, 0.0F), 3e30F})
        EXPECT_EQ(largest_majorant(entry), std::nextafter(entry, std::numeric_limits<float>::infinity()));
    EXPECT_GT(largest_majorant(0.0F), 1e-30F);
}

} // namespace
} // namespace lumisweep
