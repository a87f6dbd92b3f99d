#include "lumisweep/base/aligned.h"

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

TEST(AlignedArray, TooLargeIsBadAllocNotOverflow)
{
    EXPECT_THROW(AlignedArray<double>(static_cast<std::size_t>(-1) / 8), std::bad_alloc);
    EXPECT_THROW(AlignedArray<double>(static_cast<std::size_t>(-1)), std::bad_alloc);
}

} // namespace
} // namespace lumisweep
