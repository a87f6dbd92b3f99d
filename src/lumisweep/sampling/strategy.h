// How a direction towards the light may be chosen.
#pragma once

namespace lumisweep {

/// Journal paper, section 10: uniform over the sphere; by the environment's luminance; by the visibility grid; by the
/// product at the grid's own resolution; by the product, then by the environment below the chosen direction. All have
/// the same mean.
enum class Strategy { uniform, environment, visibility, combined, two_step };

/// "two-step" and so on, as on the command line.
const char* name_of(Strategy strategy);

} // namespace lumisweep
