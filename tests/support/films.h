// Films that are the same to the bit.
#pragma once

#include <cstring>

#include <gtest/gtest.h>

#include "lumisweep/render/film.h"

namespace lumisweep::test {

template <class T>
bool same_bits(const AlignedArray<T>& a, const AlignedArray<T>& b)
{
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.bytes()) == 0;
}

inline ::testing::AssertionResult same_film(const Film& a, const Film& b)
{
    if (a.samples() != b.samples())
        return ::testing::AssertionFailure() << a.samples() << " and " << b.samples() << " samples";
    if (!same_bits(a.arrays().features, b.arrays().features))
        return ::testing::AssertionFailure() << "features differ";
    if (!same_bits(a.arrays().color_sum, b.arrays().color_sum))
        return ::testing::AssertionFailure() << "colours differ";
    if (!same_bits(a.arrays().color_sum_squares, b.arrays().color_sum_squares))
        return ::testing::AssertionFailure() << "squares differ";
    if (!same_bits(a.arrays().block_sum_squares, b.arrays().block_sum_squares) ||
        !same_bits(a.arrays().block_begin, b.arrays().block_begin))
        return ::testing::AssertionFailure() << "blocks differ";
    return ::testing::AssertionSuccess();
}

} // namespace lumisweep::test
