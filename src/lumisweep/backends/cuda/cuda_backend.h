// The CUDA backend: the whole graph of a session on the GPU, from the same stage templates as on the CPU.
#pragma once

#include <memory>

#include "lumisweep/backends/cuda/device.h"

namespace lumisweep {
class Backend; // render/backend.h
}

namespace lumisweep::LUMISWEEP_CUDA {

/// Throws Error, one line, when this build has no CUDA or this machine no usable GPU.
std::shared_ptr<Backend> make_cuda_backend();

} // namespace lumisweep::LUMISWEEP_CUDA
