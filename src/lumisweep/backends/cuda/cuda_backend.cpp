#include "lumisweep/backends/cuda/cuda_backend.h"

#include <fmt/format.h>

#include "lumisweep/backends/cuda/cuda_scene.h"
#include "lumisweep/render/backend.h"

namespace lumisweep::LUMISWEEP_CUDA {

namespace {

class CudaBackend final : public DeviceBackend {
public:
    explicit CudaBackend(DeviceInfo info) : info_(std::move(info)) {}

    std::string device() const override { return "cuda"; }
    std::string isa() const override { return fmt::format("sm_{}, {}", info_.compute_capability, info_.name); }
    std::unique_ptr<DeviceScene> make_scene() override { return std::make_unique<CudaScene>(info_); }

private:
    DeviceInfo info_;
};

} // namespace

std::shared_ptr<Backend> make_cuda_backend() { return std::make_shared<CudaBackend>(open_device()); }

} // namespace lumisweep::LUMISWEEP_CUDA
