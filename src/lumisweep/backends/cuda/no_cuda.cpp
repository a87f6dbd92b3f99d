// In builds without CUDA.
#include "lumisweep/backends/cuda/cuda_backend.h"
#include "lumisweep/base/error.h"

namespace lumisweep::cuda {

std::shared_ptr<Backend> make_cuda_backend()
{
    fail(
        "device cuda: this program was built without CUDA (install the CUDA toolkit, 12 or newer, and build again; use "
        "--device cpu, or --device auto to fall back to it)");
}

} // namespace lumisweep::cuda
