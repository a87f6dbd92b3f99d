// Marks functions that CUDA compiles for both sides; nothing elsewhere.
#pragma once

#if defined(__CUDACC__)
#define LUMISWEEP_HD __host__ __device__ __forceinline__
#elif defined(__GNUC__) && !defined(LUMISWEEP_INLINE_AT_WILL)
// Always inlined: the stages are compiled once per instruction set, and a helper that stayed out of line could be
// merged by the linker with the copy of another instruction set.
#define LUMISWEEP_HD inline __attribute__((always_inline))
#else
#define LUMISWEEP_HD inline
#endif
