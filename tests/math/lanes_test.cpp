// The wide lane types against the scalar code, and the polynomials against double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <random>

#include "math/lane_checks.h"
#include "support/instruction_sets.h"

namespace lumisweep {
namespace {

using test::lane_count;
using test::LaneInput;
using test::LaneOutput;

/// Values of all magnitudes with ties, zeros of both signs and, where `special`, NaN and infinities.
void fill(LaneInput& in, std::mt19937& random, bool special)
{
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    const float specials[] = {0.0F,
                              -0.0F,
                              1.0F,
                              -1.0F,
                              0.5F,
                              std::numeric_limits<float>::infinity(),
                              -std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::quiet_NaN(),
                              1e-40F};
    const auto number = [&] {
        if (special && random() % 4 == 0)
            return specials[random() % std::size(specials)];
        return std::ldexp(unit(random) - 0.5F, static_cast<int>(random() % 24));
    };
    for (int i = 0; i < lane_count; ++i) {
        in.a[i] = number(), in.c[i] = number();
        in.b[i] = random() % 8 == 0 ? in.a[i] : number();
        in.positive[i] = std::ldexp(0.5F + 0.5F * unit(random), static_cast<int>(random() % 250) - 124);
        in.unit[i] = i < 2 ? static_cast<float>(i) : unit(random);
        in.eighth[i] = (unit(random) * 2.0F - 1.0F) * 0.785398F;
        in.oct_u[i] = unit(random), in.oct_v[i] = unit(random);
        in.i[i] = static_cast<std::int32_t>(random());
        in.j[i] = random() % 8 == 0 ? in.i[i] : static_cast<std::int32_t>(random());
        in.on[i] = static_cast<std::int32_t>(random() & 1U);
        in.index[i] =
            i == 0 ? LaneInput::table_size - 2 : static_cast<std::int32_t>(random() % (LaneInput::table_size - 1));
    }
    for (int g = 0; g < 48; ++g) // groups that are all on and all off
        in.on[g] = g < 16 ? 1 : g < 32 ? 0 : in.on[g];
    for (int i = 0; i < LaneInput::table_size + 4; ++i) {
        in.table_f32[i] = number();
        in.table_i32[i] = static_cast<std::int32_t>(random());
        in.table_u8[i] = static_cast<std::uint8_t>(random());
        in.table_u16[i] = static_cast<std::uint16_t>(random());
        in.table_i16[i] = static_cast<std::int16_t>(random());
    }
}

bool same_bits(float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0 || (std::isnan(a) && std::isnan(b)); }

void compare(void (*run)(const LaneInput&, LaneOutput&), int width, bool special)
{
    std::mt19937 random(42);
    const auto in = std::make_unique<LaneInput>();
    const auto scalar = std::make_unique<LaneOutput>(), wide = std::make_unique<LaneOutput>();
    for (int repeat = 0; repeat < 50; ++repeat) {
        fill(*in, random, special);
        test::run_lanes<float>(*in, *scalar);
        run(*in, *wide);
        for (int l = 0; l < lane_count; ++l) {
            for (int r = 0; r < test::f_exact_count; ++r)
                ASSERT_TRUE(same_bits(scalar->f[r][l], wide->f[r][l]))
                    << "float result " << r << ": " << scalar->f[r][l] << ", " << wide->f[r][l];
            for (int r = 0; r < test::i_count; ++r)
                ASSERT_EQ(scalar->i[r][l], wide->i[r][l]) << "int result " << r;
            if (!special) {
                ASSERT_EQ(wide->f[test::f_fma][l], std::fma(in->a[l], in->b[l], in->c[l]));
                for (int r = test::f_direction_x; r <= test::f_uv_v; ++r)
                    ASSERT_NEAR(scalar->f[r][l], wide->f[r][l], 1e-6) << "float result " << r;
            }
        }
        ASSERT_EQ(scalar->packed, wide->packed);
        for (int p = 0; p < wide->packed; ++p) {
            ASSERT_TRUE(same_bits(scalar->packed_f[p], wide->packed_f[p]));
            ASSERT_EQ(scalar->packed_i[p], wide->packed_i[p]);
        }
        for (int g = 0; g < lane_count / width; ++g) {
            std::uint32_t expected = 0;
            for (int l = 0; l < width; ++l)
                expected |= static_cast<std::uint32_t>(in->on[g * width + l]) << l;
            ASSERT_EQ(wide->bits[g], expected);
            ASSERT_EQ(wide->count[g], __builtin_popcount(expected));
            ASSERT_EQ(wide->any[g], expected != 0);
            ASSERT_EQ(wide->all[g], expected == (1U << width) - 1U);
        }
        for (int n = -1; n <= width + 1; ++n)
            ASSERT_EQ(wide->first[n + 1], (1U << std::clamp(n, 0, width)) - 1U) << n;
    }
}

/// How far x is from the exact value, in units of its last place.
double ulps(float x, double exact)
{
    const auto nearest = static_cast<float>(exact);
    const double ulp = std::fabs(double(std::nextafter(nearest, std::numeric_limits<float>::infinity())) - nearest);
    return std::fabs(x - exact) / ulp;
}

void check_polynomials(void (*run)(const LaneInput&, LaneOutput&))
{
    std::mt19937 random(43);
    const auto in = std::make_unique<LaneInput>();
    const auto out = std::make_unique<LaneOutput>();
    double worst_log = 0.0, worst_exp = 0.0, worst_reciprocal = 0.0;
    for (int repeat = 0; repeat < 100; ++repeat) {
        fill(*in, random, false);
        for (int l = 0; l < lane_count; l += 2) // around 1, where the logarithm is small: what free flights ask for
            in->positive[l] = 1.0F - static_cast<float>(random() >> 8) * 0x1p-24F;
        run(*in, *out);
        for (int l = 0; l < lane_count; ++l) {
            worst_log = std::max(worst_log, in->positive[l] == 1.0F
                                                ? std::fabs(out->f[test::f_log][l])
                                                : ulps(out->f[test::f_log][l], std::log(double(in->positive[l]))));
            worst_exp = std::max(worst_exp, ulps(out->f[test::f_exp][l], std::exp(double(in->unit[l] * -80.0F))));
            worst_reciprocal =
                std::max(worst_reciprocal, ulps(out->f[test::f_reciprocal][l], 1.0 / double(in->positive[l])));
            ASSERT_NEAR(out->f[test::f_sin][l], std::sin(double(in->eighth[l])), 1e-7);
            ASSERT_NEAR(out->f[test::f_cos][l], std::cos(double(in->eighth[l])), 1e-7);
            ASSERT_NEAR(out->f[test::f_atan][l], std::atan(double(in->unit[l])), 4e-7);
            const Vec3<double> d = direction_from_oct(UV<double>{in->oct_u[l], in->oct_v[l]});
            ASSERT_NEAR(out->f[test::f_direction_x][l], d.x, 1e-6);
            ASSERT_NEAR(out->f[test::f_direction_y][l], d.y, 1e-6);
            ASSERT_NEAR(out->f[test::f_direction_z][l], d.z, 1e-6);
        }
    }
    EXPECT_LE(worst_log, 2.0);
    EXPECT_LE(worst_exp, 2.0);
    EXPECT_LE(worst_reciprocal, 2.0);
}

TEST(Lanes, ScalarPolynomials) { check_polynomials(test::run_lanes<float>); }

TEST(Lanes, Avx2EqualsScalar)
{
    if (!test::runs_avx2())
        GTEST_SKIP() << "this machine has no AVX2";
    compare(test::run_lanes_avx2, 8, false);
    compare(test::run_lanes_avx2, 8, true);
    check_polynomials(test::run_lanes_avx2);
}

TEST(Lanes, Avx512EqualsScalar)
{
    if (!test::runs_avx512())
        GTEST_SKIP() << "this machine has no AVX-512";
    compare(test::run_lanes_avx512, 16, false);
    compare(test::run_lanes_avx512, 16, true);
    check_polynomials(test::run_lanes_avx512);
}

// The polynomial itself, for every exponent and around every cut, in scalar code.
TEST(Lanes, LogPolynomial)
{
    std::mt19937 random(44);
    double worst = 0.0;
    for (int i = 0; i < 2000000; ++i) {
        const float x =
            std::bit_cast<float>(static_cast<std::int32_t>(0x00800000U + random() % (0x7f800000U - 0x00800000U)));
        worst = std::max(worst, x == 1.0F ? 0.0 : ulps(log_polynomial(x), std::log(double(x))));
    }
    for (int i = -200000; i < 200000; ++i) {
        const float x = std::bit_cast<float>(0x3f800000 + i);
        worst = std::max(worst, x == 1.0F ? 0.0 : ulps(log_polynomial(x), std::log(double(x))));
    }
    EXPECT_LE(worst, 2.0);
    EXPECT_EQ(log_polynomial(1.0F), 0.0F);
}

TEST(Lanes, ExpPolynomial)
{
    double worst = 0.0;
    for (int i = 0; i <= 2000000; ++i) {
        const float x = -87.0F + 175.0F * static_cast<float>(i) / 2e6F;
        worst = std::max(worst, ulps(exp_polynomial(x), std::exp(double(x))));
    }
    EXPECT_LE(worst, 2.0);
    EXPECT_EQ(exp_polynomial(0.0F), 1.0F);
    for (const float x : {-88.0F, -1e3F, -1e30F, -std::numeric_limits<float>::infinity()}) {
        EXPECT_GE(exp_polynomial(x), 0.0F);
        EXPECT_LT(exp_polynomial(x), 2e-38F);
    }
}

} // namespace
} // namespace lumisweep
