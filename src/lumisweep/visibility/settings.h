// Settings of the visibility grid; names and defaults are the scene file's.
#pragma once

#include <array>
#include <string_view>

namespace lumisweep {

enum class SweepFilter { none, half_angle, full_angle };
/// In the order of the enumerators.
inline constexpr std::array<std::string_view, 3> filter_names{"none", "half-angle", "full-angle"};

struct VisibilitySettings {
    int directions = 8; ///< n of the n × n octahedral map: 1, 2, 4, 8, 16 or 32
    int cell = 4;       ///< voxels of the volume per visibility cell along each axis, 1 … 64
    int rays = 0;       ///< s of the s × s sweep kernel; 0 is "auto"
    SweepFilter filter = SweepFilter::half_angle;
    int oversampling = 1; ///< lines swept per direction and averaged: 1, 4 or 16
    /// Added to V before normalising; > 0, else a wrong V = 0 could bias the image. The papers take 0.01; 0.1 leaves as
    /// little noise on average and less where the gain is smallest (docs/results/ablation.md).
    double epsilon = 0.1;

    /// Throws Error naming the entry ("visibility.cell") that is out of range.
    void validate() const;
    bool operator==(const VisibilitySettings&) const = default;
};

} // namespace lumisweep
