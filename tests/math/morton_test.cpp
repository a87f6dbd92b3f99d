#include "lumisweep/math/morton.h"

#include <cstdint>
#include <random>

#include <gtest/gtest.h>

namespace lumisweep {
namespace {

std::int32_t encode_bit_by_bit(std::int32_t x, std::int32_t y)
{
    std::uint32_t m = 0;
    for (int bit = 0; bit < 16; ++bit) {
        m |= ((static_cast<std::uint32_t>(x) >> bit) & 1U) << (2 * bit);
        m |= ((static_cast<std::uint32_t>(y) >> bit) & 1U) << (2 * bit + 1);
    }
    return static_cast<std::int32_t>(m);
}

void expect_round_trip(std::int32_t x, std::int32_t y)
{
    const std::int32_t m = morton_encode(x, y);
    ASSERT_EQ(m, encode_bit_by_bit(x, y)) << x << ' ' << y;
    const TexelXY<std::int32_t> back = morton_decode(m);
    ASSERT_EQ(back.x, x);
    ASSERT_EQ(back.y, y);
}

TEST(Morton, InterleavesBits)
{
    for (std::int32_t y = 0; y < 64; ++y)
        for (std::int32_t x = 0; x < 64; ++x)
            expect_round_trip(x, y);
    for (const std::int32_t x : {0, 1, 16383, 16384, 32767, 65535})
        for (const std::int32_t y : {0, 1, 16383, 16384, 32767, 65535})
            expect_round_trip(x, y); // y above 32767 sets the sign bit: it must not smear
    std::mt19937 random(4);
    for (int i = 0; i < 20000; ++i)
        expect_round_trip(static_cast<std::int32_t>(random() % 65536), static_cast<std::int32_t>(random() % 65536));
}

TEST(Morton, ChildrenOfANodeAreContiguous)
{
    for (std::int32_t y = 0; y < 40; ++y)
        for (std::int32_t x = 0; x < 40; ++x)
            for (std::int32_t child = 0; child < 4; ++child)
                ASSERT_EQ(morton_encode(2 * x + child % 2, 2 * y + child / 2), 4 * morton_encode(x, y) + child);
}

} // namespace
} // namespace lumisweep
