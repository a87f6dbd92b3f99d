// How a direction towards the light may be chosen.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace lumisweep {

/// The papers' five (journal paper, section 10): uniform over the sphere; by the environment's luminance; by the
/// visibility grid; by the product at the grid's own resolution; by the product, then by the environment below the
/// chosen direction. Automatic is what leaves the least noise for the time, whatever its parts
/// (docs/results/efficiency.md): two-step's density with stratified numbers and several collisions a camera ray
/// (render/settings.h). All have the same mean.
enum class Strategy { uniform, environment, visibility, combined, two_step, automatic };

/// As on the command line, in the order of the enumerators.
inline constexpr std::array<std::string_view, 6> strategy_names{"uniform",  "environment", "visibility",
                                                                "combined", "two-step",    "auto"};

inline std::string name_of(Strategy strategy)
{
    return std::string(strategy_names[static_cast<std::size_t>(strategy)]);
}

} // namespace lumisweep
