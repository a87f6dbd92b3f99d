#include "lumisweep/base/aligned.h"

#include <algorithm>
#include <cstdint>

#include <gtest/gtest.h>

namespace lumisweep {
namespace {

TEST(AlignedArray, AlignedZeroedAndReadableBeyondTheEnd)
{
    for (std::size_t n : {0U, 1U, 15U, 16U, 17U, 1000U}) {
        AlignedArray<float> a(n);
        EXPECT_EQ(a.size(), n);
        EXPECT_EQ(a.bytes(), 4 * n);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(a.data()) % 64, 0U);
        // Under AddressSanitizer this fails when the padding is missing.
        for (std::size_t i = 0; i < n + 16; ++i)
            EXPECT_EQ(a.data()[i], 0.0F);
    }
}

TEST(AlignedArray, LargeArraysLieInLargePages)
{
    for (const Contents contents : {Contents::zeros, Contents::uninitialised})
        for (std::size_t bytes : {large_pages_from - 65, large_pages_from - 64, large_pages_from, 3 * large_page + 1}) {
            AlignedArray<std::uint8_t> a(bytes, contents);
            const std::size_t alignment = bytes + 64 < large_pages_from ? 64 : large_page;
            EXPECT_EQ(reinterpret_cast<std::uintptr_t>(a.data()) % alignment, 0U);
            std::fill(a.begin(), a.end(), std::uint8_t{3});
            for (std::size_t i = bytes; i < bytes + 64; ++i)
                EXPECT_EQ(a.data()[i], 0);
            AlignedArray<std::uint8_t> moved = std::move(a);
            a = AlignedArray<std::uint8_t>(100);
            moved = std::move(a); // gives the large pages back
            EXPECT_EQ(moved[99], 0);
        }
    const AlignedArray<double> zeros(3000000);
    EXPECT_EQ(std::count(zeros.begin(), zeros.end(), 0.0), 3000000);
}

TEST(AlignedArray, TooLargeIsBadAllocNotOverflow)
{
    EXPECT_THROW(AlignedArray<double>(static_cast<std::size_t>(-1) / 8), std::bad_alloc);
    EXPECT_THROW(AlignedArray<double>(static_cast<std::size_t>(-1)), std::bad_alloc);
}

} // namespace
} // namespace lumisweep
