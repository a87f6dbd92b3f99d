#if defined(__x86_64__)
#define LUMISWEEP_SWEEP_KERNELS sweep_kernels_avx2
#define LUMISWEEP_SWEEP_KERNELS_NAME "avx2"
#include "lumisweep/visibility/sweep_kernel_impl.h"
#endif
