// A kernel of nothing but products of four bytes.
#pragma once

#include <cstdint>

#include "lumisweep/backends/cuda/device.h"

namespace lumisweep::LUMISWEEP_CUDA {

struct ProductLoad {
    static constexpr int threads = 256, chains = 8; ///< that do not wait for each other
    int blocks, rounds;

    /// Instructions of all threads.
    double products() const { return 1.0 * blocks * threads * chains * rounds; }
};

void multiply_bytes(const ProductLoad& load, std::uint8_t* result, const Stream& stream);

} // namespace lumisweep::LUMISWEEP_CUDA
