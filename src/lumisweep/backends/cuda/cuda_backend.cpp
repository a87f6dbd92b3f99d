#include "lumisweep/backends/cuda/cuda_backend.h"

#include <fmt/format.h>

#include "lumisweep/backends/cuda/cuda_scene.h"
#include "lumisweep/backends/cuda/draw_paths.h"
#include "lumisweep/base/error.h"
#include "lumisweep/render/backend.h"

namespace lumisweep::LUMISWEEP_CUDA {

namespace {

class CudaBackend final : public DeviceBackend {
public:
    explicit CudaBackend(DeviceInfo info) : info_(std::move(info)) {}

    std::string device() const override { return "cuda"; }
    std::string isa() const override { return fmt::format("sm_{}", info_.compute_capability); }
    std::string model() const override { return info_.name; }
    std::unique_ptr<DeviceScene> make_scene() override { return std::make_unique<CudaScene>(info_); }

private:
    DeviceInfo info_;
};

} // namespace

std::shared_ptr<Backend> make_cuda_backend()
{
    DeviceInfo info = open_device();
    require(can_draw_paths(),
            "device cuda: this program was built for other GPUs than {}, of compute capability {}.{} "
            "(build with -DCMAKE_CUDA_ARCHITECTURES={}, or use --device cpu)",
            info.name, info.compute_capability / 10, info.compute_capability % 10, info.compute_capability);
    return std::make_shared<CudaBackend>(std::move(info));
}

} // namespace lumisweep::LUMISWEEP_CUDA
