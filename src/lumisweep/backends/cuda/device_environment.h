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
        view_ = environment.view();
        const std::size_t texels = std::size_t{1} << (2 * view_.levels);
        radiance_.upload({view_.radiance, 3 * texels}, "the light", stream);
        luminance_.upload({view_.luminance, (4 * texels - 1) / 3}, "the light", stream);
        stream.wait();
        view_.radiance = radiance_.data();
        view_.luminance = luminance_.data();
    }
    EnvironmentView view() const { return view_; }
    std::uint64_t bytes() const { return radiance_.bytes() + luminance_.bytes(); }

private:
    EnvironmentView view_;
    DeviceArray<float> radiance_, luminance_;
};

} // namespace lumisweep::LUMISWEEP_CUDA
