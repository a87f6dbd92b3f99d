#include "lumisweep/visibility/dither.h"

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

namespace lumisweep {
namespace {

std::vector<std::uint16_t> shuffled()
{
    constexpr std::uint32_t count = 1U << 16;
    std::vector<std::uint16_t> numbers(count + dither_run);
    std::mt19937 random(20150713); // fixed: rounding is a function of the voxel alone
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t j = static_cast<std::uint32_t>(std::uint64_t{random()} * (i + 1) >> 32);
        numbers[i] = numbers[j];
        numbers[j] = static_cast<std::uint16_t>(i);
    }
    std::copy_n(numbers.begin(), dither_run, numbers.begin() + count);
    return numbers;
}

} // namespace

const std::uint16_t* dither_numbers()
{
    static const std::vector<std::uint16_t> numbers = shuffled();
    return numbers.data();
}

} // namespace lumisweep
