#include "lumisweep/scene/hash.h"

#include <array>
#include <bit>
#include <cstring>

#include <fmt/format.h>

namespace lumisweep {

namespace {

// Odd constants with well-mixed bits; the finaliser is MurmurHash3's fmix64.
constexpr std::uint64_t multiplier = 0x9e3779b97f4a7c15U;

std::uint64_t finalized(std::uint64_t h)
{
    h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdU;
    h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53U;
    return h ^ (h >> 33);
}

std::uint64_t mixed(std::uint64_t state, std::uint64_t word)
{
    return std::rotl(state ^ (word * multiplier), 29) * multiplier;
}

} // namespace

std::uint64_t hash_bytes(const void* data, std::size_t size, std::uint64_t seed)
{
    const auto* bytes = static_cast<const unsigned char*>(data);
    std::array<std::uint64_t, 4> lane{seed ^ 1, seed ^ 2, seed ^ 3,
                                      seed ^ 4}; // four chains, so that multiplies overlap
    std::size_t at = 0;
    for (; at + 32 <= size; at += 32)
        for (std::size_t l = 0; l < 4; ++l) {
            std::uint64_t word;
            std::memcpy(&word, bytes + at + 8 * l, 8);
            lane[l] = mixed(lane[l], word);
        }
    std::array<unsigned char, 32> tail{};
    if (at < size)
        std::memcpy(tail.data(), bytes + at, size - at);
    for (std::size_t l = 0; l < 4; ++l) {
        std::uint64_t word;
        std::memcpy(&word, tail.data() + 8 * l, 8);
        lane[l] = mixed(lane[l], word);
    }
    std::uint64_t h = mixed(seed, size);
    for (const std::uint64_t l : lane)
        h = mixed(h, finalized(l));
    return finalized(h);
}

std::string hex(std::uint64_t value) { return fmt::format("{:016x}", value); }

} // namespace lumisweep
