#if defined(__x86_64__)
#define LUMISWEEP_SWEEP_KERNELS sweep_kernels_avx512
#define LUMISWEEP_SWEEP_KERNELS_NAME "avx512"
#include "lumisweep/visibility/sweep_kernel_impl.h"
#endif
