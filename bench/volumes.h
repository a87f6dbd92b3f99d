// The volumes that are measured: generated ones, two of which look like data, noise included, and a real one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep::bench {

struct Specimen {
    std::string name; ///< as in the names of the benchmarks
    ScalarGrid volume;
    TransferFunction transfer_function;
};

/// A head in Hounsfield units (i16) in a box about 256 world units wide: skin, a skull of two tables with spongy bone
/// between, sinuses and mastoid cells behind thin walls, orbits, contrast medium in vessels, scanner noise. Its
/// transfer function is steep: bone is opaque within a few voxels, soft tissue empty.
Specimen ct_like(Vec3i size);

/// A plume of fractal density (i16), with an optical depth of about 3 along x through its middle.
Specimen smoke_like(Vec3i size);

/// Thin nested shells with fractal surfaces (u8), about 95 % of the voxels empty at 384³. The transfer function is such
/// that rays along x that meet any of it have `mean_optical_depth` on average.
Specimen fractal_shells(Vec3i size, double mean_optical_depth);

/// Voxels of equal sides; the box is 256 world units along x, and centred.
Affine3d centred_box(Vec3i size);

/// The real MR of a head that scripts/fetch_data brings, 301 × 370 × 316 in 8 bits; nothing when it is not in `data`.
std::optional<Specimen> ch2better(const std::filesystem::path& data);

/// The same object with twice the voxels along each axis (linear interpolation between the given ones), in 8 bits. Of
/// i16 or u8.
Specimen doubled(const Specimen& specimen);

} // namespace lumisweep::bench
