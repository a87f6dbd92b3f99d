// Several neighbours in memory at a time, as words of 32 bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/math/lanes.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Loaded and stored in pieces of up to 16 bytes.
template <int count>
struct alignas(count >= 4 ? 16 : 4 * count) Words {
    std::uint32_t word[count];
};

/// From any address, in words that lie in memory as words: up to 4 bytes behind them are read too.
template <int count>
LUMISWEEP_HD Words<count> load_words(const void* address)
{
    const auto first = reinterpret_cast<std::uintptr_t>(address) % 4;
    const auto* from = reinterpret_cast<const std::uint32_t*>(static_cast<const std::byte*>(address) - first);
    Words<count> words;
    std::uint32_t low = from[0];
    LUMISWEEP_UNROLL
    for (int i = 0; i < count; ++i) {
        const std::uint32_t high = from[i + 1];
        words.word[i] = bytes_from(low, high, static_cast<int>(first));
        low = high;
    }
    return words;
}

/// From an address aligned as they are.
template <int count>
LUMISWEEP_HD Words<count> load_aligned_words(const void* address)
{
    return *static_cast<const Words<count>*>(address);
}

/// Number i of those that lie in the words.
template <class T, int count>
LUMISWEEP_HD T number_in(const Words<count>& words, int i)
{
    constexpr int per_word = 4 / static_cast<int>(sizeof(T));
    const std::uint32_t word = words.word[i / per_word];
    if constexpr (std::is_same_v<T, float>)
        return as_float(static_cast<std::int32_t>(word));
    else
        return static_cast<T>(word >> (8 * static_cast<int>(sizeof(T)) * (i % per_word)));
}

/// Byte c of word r becomes byte r of word c.
LUMISWEEP_HD Words<4> transposed_bytes(const Words<4>& rows)
{
    constexpr std::uint32_t even = 0x00ff00ffU, low = 0x0000ffffU;
    const auto evens = [&](int r) { return (rows.word[r] & even) | (rows.word[r + 1] & even) << 8; };
    const auto odds = [&](int r) { return (rows.word[r] >> 8 & even) | (rows.word[r + 1] & ~even); };
    const std::uint32_t even_top = evens(0), even_bottom = evens(2), odd_top = odds(0), odd_bottom = odds(2);
    return {{(even_top & low) | even_bottom << 16, (odd_top & low) | odd_bottom << 16,
             even_top >> 16 | (even_bottom & ~low), odd_top >> 16 | (odd_bottom & ~low)}};
}

} // namespace lumisweep::LUMISWEEP_CUDA
