// One result of all threads of a block.
#pragma once

#include "lumisweep/backends/cuda/launch.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Folds values [threads] in shared memory, one of each thread, into the first; threads is a power of two.
template <int threads, class T, class Fold>
LUMISWEEP_HD void reduce(const Block<threads>& block, T* values, Fold&& fold)
{
    static_assert((threads & (threads - 1)) == 0);
    for (int half = threads / 2; half > 0; half /= 2)
        block.run([&](int thread) {
            if (thread < half)
                values[thread] = fold(values[thread], values[thread + half]);
        });
}

} // namespace lumisweep::LUMISWEEP_CUDA
