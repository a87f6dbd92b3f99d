// Smooth value noise on lattices, evaluated a row of voxels at a time so that 512³ voxels take seconds.
#pragma once

#include <cstdint>
#include <vector>

#include "lumisweep/math/vec.h"

namespace lumisweep::bench {

/// Sums octaves of random values on cubic lattices, joined by smoothstep weights. Octave o has lattice cells of
/// period / 2^o voxels and amplitude gain^o; one octave lies in [−1, 1]. The same for the same seed on every machine.
class LatticeNoise {
public:
    LatticeNoise(Vec3i size, double period_voxels, int octaves, double gain, std::uint64_t seed);

    /// row[i] += amplitude · noise at voxel (i, j, k).
    void add_row(int j, int k, float amplitude, float* row) const;

private:
    struct Octave {
        int lattice_x, lattice_y;
        float amplitude;
        std::vector<std::int32_t> base_x, base_y, base_z; // lattice point on the low side, per voxel
        std::vector<float> weight_x, weight_y, weight_z;  // towards the next
        std::vector<float> values;                        // [z][y][x]
    };
    int size_x_;
    std::vector<Octave> octaves_;
};

} // namespace lumisweep::bench
