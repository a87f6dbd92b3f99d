// Which backend: by the names that the command line and Python use.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>

namespace lumisweep {

class Backend; // render/backend.h

/// Where to compute. Automatic is CUDA where there is a usable GPU, else the CPU.
enum class Device { automatic, cpu, cuda };
/// In the order of the enumerators.
inline constexpr std::array<std::string_view, 3> device_names{"auto", "cpu", "cuda"};

/// Throws Error for a name that is none of them.
Device device_of(const std::string& name);

struct ChosenBackend {
    std::shared_ptr<Backend> backend;
    std::string note; ///< why `automatic` took the CPU; else empty
};

/// `isa` as for make_cpu_backend(). Throws Error, one line, when the device is not there or the build lacks it.
ChosenBackend make_backend(Device device, const std::string& isa = "auto");

} // namespace lumisweep
