// A direction sampler with the volume that places it in the world.
#pragma once

#include <memory>

#include "bindings.h"

namespace lumisweep::python {

struct SamplerHandle {
    std::shared_ptr<const DirectionSampler> sampler;
    std::shared_ptr<const ScalarGrid> volume;
};

/// `visibility` may be nullptr for uniform and environment.
SamplerHandle make_sampler(Strategy strategy, std::shared_ptr<const ScalarGrid> volume,
                           std::shared_ptr<const Environment> environment, const VisibilityGrid* visibility,
                           double epsilon);

} // namespace lumisweep::python
