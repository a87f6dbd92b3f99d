// Natural light (light/environment.h) in the device's memory.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/light/environment.h"

namespace lumisweep::LUMISWEEP_CUDA {

class DeviceEnvironment {
public:
    /// Waits.
    void upload(const Environment& environment, const Stream& stream)
    {
        const EnvironmentView host = environment.view();
        const std::size_t texels = std::size_t{1} << (2 * host.levels);
        radiance_.upload({host.radiance, 3 * texels}, "the light", stream);
        luminance_.upload({host.luminance, (4 * texels - 1) / 3}, "the light", stream);
        stream.wait();
        view_ = {host.levels, radiance_.data(), luminance_.data()};
    }
    EnvironmentView view() const { return view_; }
    std::uint64_t bytes() const { return radiance_.bytes() + luminance_.bytes(); }

private:
    EnvironmentView view_;
    DeviceArray<float> radiance_, luminance_;
};

} // namespace lumisweep::LUMISWEEP_CUDA
