#include "lumisweep/backends/make_backend.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "lumisweep/backends/cpu/cpu_backend.h"
#include "lumisweep/backends/cuda/cuda_backend.h"
#include "lumisweep/base/error.h"

namespace lumisweep {

Device device_of(const std::string& name)
{
    const auto* const found = std::find(device_names.begin(), device_names.end(), name);
    require(found != device_names.end(), "device: \"{}\" is not one of {}", name, fmt::join(device_names, ", "));
    return static_cast<Device>(found - device_names.begin());
}

ChosenBackend make_backend(Device device, const std::string& isa)
{
    // Also where it will not be used: a wrong name is wrong everywhere.
    std::shared_ptr<Backend> cpu = make_cpu_backend(isa);
    if (device == Device::cpu)
        return {std::move(cpu), {}};
    try {
        return {cuda::make_cuda_backend(), {}};
    } catch (const Error& error) {
        if (device == Device::cuda)
            throw;
        const std::string reason = error.what(); // and, in parentheses, how to mend it
        return {std::move(cpu), "rendering on the CPU: " + reason.substr(0, reason.rfind(" ("))};
    }
}

} // namespace lumisweep
