#include "lattice_noise.h"

#include <cmath>
#include <random>

namespace lumisweep::bench {
namespace {

/// Where the voxels of one axis lie on the lattice; returns the number of lattice points.
int place(int voxels, double period, std::vector<std::int32_t>& base, std::vector<float>& weight)
{
    base.resize(static_cast<std::size_t>(voxels));
    weight.resize(base.size());
    for (std::size_t i = 0; i < base.size(); ++i) {
        const double x = (static_cast<double>(i) + 0.5) / period;
        base[i] = static_cast<std::int32_t>(x);
        const double t = x - base[i];
        weight[i] = static_cast<float>(t * t * (3.0 - 2.0 * t));
    }
    return base.back() + 2;
}

} // namespace

LatticeNoise::LatticeNoise(Vec3i size, double period_voxels, int octaves, double gain, std::uint64_t seed)
    : size_x_(size.x)
{
    std::mt19937_64 random(seed);
    for (int o = 0; o < octaves; ++o) {
        Octave& octave = octaves_.emplace_back();
        const double period = std::ldexp(period_voxels, -o);
        octave.amplitude = static_cast<float>(std::pow(gain, o));
        octave.lattice_x = place(size.x, period, octave.base_x, octave.weight_x);
        octave.lattice_y = place(size.y, period, octave.base_y, octave.weight_y);
        const int lattice_z = place(size.z, period, octave.base_z, octave.weight_z);
        octave.values.resize(static_cast<std::size_t>(octave.lattice_x) * static_cast<std::size_t>(octave.lattice_y) *
                             static_cast<std::size_t>(lattice_z));
        // Not uniform_real_distribution: its values may differ between standard libraries.
        for (float& value : octave.values)
            value = static_cast<float>(static_cast<double>(random() >> 11) * 0x1p-52 - 1.0);
    }
}

void LatticeNoise::add_row(int j, int k, float amplitude, float* row) const
{
    std::vector<float> line;
    for (const Octave& octave : octaves_) {
        const auto y = static_cast<std::size_t>(j), z = static_cast<std::size_t>(k);
        const auto lattice_x = static_cast<std::size_t>(octave.lattice_x);
        const std::size_t slice = lattice_x * static_cast<std::size_t>(octave.lattice_y);
        const float* v00 = octave.values.data() + static_cast<std::size_t>(octave.base_z[z]) * slice +
                           static_cast<std::size_t>(octave.base_y[y]) * lattice_x;
        const float *v10 = v00 + lattice_x, *v01 = v00 + slice, *v11 = v01 + lattice_x;
        const float wy = octave.weight_y[y], wz = octave.weight_z[z], scale = amplitude * octave.amplitude;
        line.resize(lattice_x);
        for (std::size_t i = 0; i < lattice_x; ++i) {
            const float low = v00[i] + (v10[i] - v00[i]) * wy, high = v01[i] + (v11[i] - v01[i]) * wy;
            line[i] = scale * (low + (high - low) * wz);
        }
        for (std::size_t i = 0; i < static_cast<std::size_t>(size_x_); ++i) {
            const float* at = line.data() + octave.base_x[i];
            row[i] += at[0] + (at[1] - at[0]) * octave.weight_x[i];
        }
    }
}

} // namespace lumisweep::bench
