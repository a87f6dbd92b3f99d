// What is measured of a device, all through sessions, so that the CPU goes through the same program.
#pragma once

#include <functional>
#include <memory>

#include <nlohmann/json.hpp>

#include "scenes.h"

namespace lumisweep {
class Backend;
}

namespace lumisweep::bench {

struct DeviceSubject {
    std::function<std::shared_ptr<Backend>()> make_backend;
    SceneSources sources;
    bool quick = false; ///< small volumes, few repetitions
};

/// One edit and some passes of the CT-like volume at full size, and passes of the smoke-like one.
void run_for_profiler(const DeviceSubject& subject);

/// Seconds of an edit's stages (majorants, classification, sweep, product), least and median of several, by rays and
/// cells; and voxel steps a second of the sweep.
nlohmann::ordered_json measure_edits(const DeviceSubject& subject);
/// Wall-clock seconds from an edit of the transfer function to the first new sample of every pixel, in the host's
/// memory.
nlohmann::ordered_json measure_first_sample(const DeviceSubject& subject);
/// Paths a second of the CT-like and the smoke-like volume, with what shares of lanes worked.
nlohmann::ordered_json measure_paths(const DeviceSubject& subject);
/// Single samples and means beside the CPU's scalar instantiation.
nlohmann::ordered_json measure_equality(const DeviceSubject& subject);
/// Frames a second of a time series at one sample a frame, with the next frame copied beforehand and without.
nlohmann::ordered_json measure_series(const DeviceSubject& subject);

} // namespace lumisweep::bench
