// The rays of one line through the volume, and where the cells look up between them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lumisweep/base/aligned.h"
#include "lumisweep/visibility/extinction_grid.h"
#include "lumisweep/visibility/sweep_geometry.h"
#include "lumisweep/visibility/sweep_kernel.h"
#include "lumisweep/visibility/sweep_level.h"

namespace lumisweep {

/// The marched level and the cells on it.
struct MarchedLevel : SweepLevel {
    const std::uint8_t* voxels;                               ///< x fastest, then y, then z
    const std::uint8_t* transposed;                           ///< y fastest, then z, then x; only for sweeps along x
    const ExtinctionGrid::Filled *filled, *filled_transposed; ///< of the rows of either
    double extinction_of_one;                                 ///< 1/world unit per stored step
};

/// Where the cells of a line look up, for each slice of cells.
struct CellPlaces {
    int step = 0;                  ///< between the rays of neighbouring cells, if it and the fraction are constant
    std::vector<std::int32_t> ray; ///< [slice][cell] less first_ray
    std::vector<float> fraction;   ///< [slice][cell] towards the next ray
    std::vector<double> depths;    ///< [slice]
    int cells = 0;

    void place(const SweepAxis& axis, int cell_count, double cell_side, std::span<const double> lookup_depths);
    const std::int32_t* rays_of(int slice) const { return ray.data() + static_cast<std::ptrdiff_t>(slice) * cells; }
    const float* fractions_of(int slice) const { return fraction.data() + static_cast<std::ptrdiff_t>(slice) * cells; }
};

/// All rays of a direction and its opposite.
class RayPlane {
public:
    /// Keeps the memory of the direction before.
    void start(const MarchedLevel& level, const Vec3d& w_world);

    const SweepGeometry& geometry() const { return *geometry_; }
    const CellPlaces& places_u() const { return u_; }
    const CellPlaces& places_v() const { return v_; }
    /// Optical depth in units of 1/127 stored step × slice, from the start face to the cells: [w][v][u].
    const float* tau_of(int slice, int row) const
    {
        return tau_.data() + (static_cast<std::ptrdiff_t>(slice) * v_.cells + row) * u_.cells;
    }
    float* tau_of(int slice, int row)
    {
        return const_cast<float*>(static_cast<const RayPlane*>(this)->tau_of(slice, row));
    }
    /// Interpolates what the rays hold now at a row of cells.
    void look_up(const SweepKernels& kernels, int slice, int row, float* tau);

    std::int32_t* row(int ray_row);
    int half_row() const { return half_row_; }
    /// Pieces of slices up to lookup `slab`, and for slab = slices of cells the rest behind the last.
    std::span<const SweepPiece> slab(int slab) const { return slabs_.slab(slab); }

private:
    /// LookupRow::step: even and odd rays are stored apart; 0 also for steps that the kernels have no loop for.
    int row_step() const
    {
        return u_.step == 1 ? neighbouring_rays : u_.step == 2 || u_.step == 4 || u_.step == 8 ? u_.step / 2 : 0;
    }

    std::unique_ptr<SweepGeometry> geometry_;
    CellPlaces u_, v_;
    SweepSlabs slabs_;
    int half_row_ = 0;                       ///< rays of one parity in a row
    AlignedArray<std::int32_t> rays_;        ///< [ray row][parity][ray / 2]
    std::vector<std::uint8_t> started_;      ///< [ray row] has been set to zero
    std::vector<std::int32_t> index_, next_; ///< [cell] where its two rays are stored in a row …
    int indexed_slice_ = -1;                 ///< … for the lookups of this slice
    AlignedArray<float> tau_;
};

} // namespace lumisweep
