// Transfer functions by name that give a good first picture without tuning.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "lumisweep/scene/value_statistics.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep {

/// What presets know of the data that they are for.
struct PresetInput {
    std::string modality; ///< DICOM's code, or empty
    ValueStatistics values;
    double diameter = 200.0; ///< of the volume's box, world units: the cube root of its volume
    int frames = 1;          ///< more than one: a time series
};

/// Of a volume in memory; `modality` is DICOM's code or empty.
PresetInput preset_input(const ScalarGrid& volume, ValueStatistics values, const std::string& modality, int frames);

/// "ct-bone", "ct-soft-tissue", "ct-vessels-and-metal", "mr-default", "smoke".
std::span<const std::string_view> preset_names();

struct PresetChoice {
    std::string name;
    std::string reason; ///< a sentence for the user: "no preset named: took ct-bone because the modality is CT"
};
PresetChoice choose_preset(const PresetInput& input);

/// CT presets are in Hounsfield units, shifted where the data evidently stores HU + 1024, with extinction per
/// millimetre; the others scale with the data's histogram and the volume's size. Throws Error for an unknown name.
std::vector<TransferPoint> preset_points(std::string_view name, const PresetInput& input);

/// What is added to Hounsfield units in this data: 1024 where unsigned storage without an intercept is evident, else 0.
double hounsfield_offset(const ValueStatistics& values);

} // namespace lumisweep
