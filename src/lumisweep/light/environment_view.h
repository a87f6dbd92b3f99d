// Natural light as kernels read it.
#pragma once

namespace lumisweep {

/// What kernels read; a plain struct of pointers.
/// Memory: radiance 12 · n² bytes, luminance 4 · (4 n² − 1) / 3 bytes.
struct EnvironmentView {
    int levels = 0;                   ///< log2 n
    const float* radiance = nullptr;  ///< [n²][3], RGB, Morton order
    const float* luminance = nullptr; ///< node m of level l (2^l × 2^l nodes) at [(4^l − 1)/3 + m]: mean luminance
};

} // namespace lumisweep
