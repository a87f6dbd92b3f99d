#include "lumisweep/sampling/strategy.h"

namespace lumisweep {

const char* name_of(Strategy strategy)
{
    switch (strategy) {
    case Strategy::uniform: return "uniform";
    case Strategy::environment: return "environment";
    case Strategy::visibility: return "visibility";
    case Strategy::combined: return "combined";
    case Strategy::two_step: return "two-step";
    case Strategy::automatic: return "auto";
    }
    return "unknown";
}

} // namespace lumisweep
