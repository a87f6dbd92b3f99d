// What the device itself can do, for the fractions that sweeps and paths reach of it.
#pragma once

#include <nlohmann/json.hpp>

namespace lumisweep::bench {

/// Bytes a second of copies within the device's memory (read and written) and from the host; products of four bytes a
/// second of all multiprocessors; what the driver and the runtime are.
nlohmann::ordered_json measure_ceilings();

} // namespace lumisweep::bench
