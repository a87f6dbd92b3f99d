// What transmittance estimators read and write: plain structs of pointers, for files of any instruction set.
#pragma once

#include <cstdint>

#include "lumisweep/render/pass.h"
#include "lumisweep/render/scene_view.h"

namespace lumisweep::bench {

/// How T = exp(−∫σ) along a shadow ray is estimated. All are unbiased.
enum class Transmittance {
    /// Woodcock 1965: 1 unless a real collision comes first.
    delta,
    /// The product of 1 − σ/majorant over tentative collisions, with roulette below a threshold (Novák et al. 2014).
    ratio,
    /// Residual ratio tracking (Novák et al. 2014): a control extinction per cell in closed form, ratio tracking for
    /// what
    /// differs from it.
    residual,
    /// Kettunen et al. 2021, "An unbiased ray-marching transmittance estimator" (ACM TOG 40(4)).
    march,
    /// The same for what exceeds the cell's smallest extinction; roulette by the closed part before the march.
    bounded_march,
};

/// Voxels per cell of the bounds along each axis. Cells have their sides through voxel centres: interpolation within
/// one depends on few voxels then.
inline constexpr int bounds_cell = 2;

/// Extinction bounds per cell, x fastest. Memory: majorant [cells]; residual [cells][2]: the
/// largest distance from a control extinction upwards, which is at least that downwards, and the control.
struct CellBoundsView {
    const float* majorant = nullptr;
    const float* residual = nullptr;
    int nx = 0, ny = 0, nz = 0;
};

/// Shadow rays in voxel space, to the border of the volume. Arrays are readable for 16 elements behind the end.
struct ShadowRaysView {
    const float* origin[3] = {};
    const float* direction[3] = {};
    const std::int32_t* key[2] = {}; ///< of the path's random numbers
    int count = 0;
};

struct TransmittanceCounts {
    std::uint64_t cells = 0;   ///< steps from cell to cell
    std::uint64_t lookups = 0; ///< of extinction
};

/// Rows of optical depths that marching keeps for the rays of higher order.
inline constexpr int largest_order = 15;

struct TransmittanceJob {
    SceneView scene;
    CellBoundsView bounds;
    ShadowRaysView rays;
    Transmittance method = Transmittance::delta;
    const float* threshold = nullptr; ///< [rays]: roulette below this transmittance; above 1 also before the start
    std::int32_t repetition = 0;      ///< makes independent estimates of the same rays
    float* estimates = nullptr;       ///< [rays], zeros
    float* combs = nullptr;           ///< [rays][largest_order + 1]; marching only
    TransmittanceCounts counts;
};

/// Where first collisions send shadow rays; arrays have room for every path and one vector more.
struct ShadowSink {
    float* origin[3] = {};
    float* direction[3] = {};
    std::int32_t* key[2] = {};
    std::int32_t* pixel = nullptr;
    std::int32_t* collision = nullptr; ///< numbers the collisions of one pass; the rays of one have the same
    float* weight = nullptr;           ///< luminance of ρ L / (4π pdf)
    int count = 0;
    int collisions = 0;
};

struct CollectJob {
    SceneView scene;
    PassNumbers pass;
    int directions = 1; ///< drawn per collision
    ShadowSink sink;
};

/// One per instruction set.
struct TransmittanceKernels {
    const char* name;
    void (*estimate)(TransmittanceJob& job);
    void (*collect)(CollectJob& job);
};

extern const TransmittanceKernels transmittance_baseline;
#if defined(__x86_64__)
extern const TransmittanceKernels transmittance_avx2;
extern const TransmittanceKernels transmittance_avx512;
#endif

} // namespace lumisweep::bench
