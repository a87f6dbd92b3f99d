#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "lattice_noise.h"
#include "lumisweep/base/parallel.h"
#include "volumes.h"

namespace lumisweep::bench {

Specimen fractal_shells(Vec3i size, double mean_optical_depth)
{
    constexpr std::array<float, 4> radii{0.26F, 0.44F, 0.62F, 0.80F}; // of half the longest side
    const int side = std::max({size.x, size.y, size.z});
    const LatticeNoise relief(size, side / 4.0, 6, 0.65, 21); // its surfaces have dimension 3 + log2(0.65) = 2.4
    const float unit = 2.0F / static_cast<float>(side), thickness = 0.009F;
    Specimen specimen{"shells", ScalarGrid(VoxelType::u8, size, centred_box(size)), TransferFunction()};
    std::uint8_t* voxels = specimen.volume.voxels<std::uint8_t>();
    const auto row_length = static_cast<std::size_t>(size.x), rows_per_slice = static_cast<std::size_t>(size.y);
    std::vector<double> row_sums(rows_per_slice * static_cast<std::size_t>(size.z));
    const auto from_centre = [unit](int i, int n) {
        return (static_cast<float>(i) + 0.5F - 0.5F * static_cast<float>(n)) * unit;
    };
    parallel_for(0, size.z, [&](int k) {
        std::vector<float> bend(row_length);
        for (int j = 0; j < size.y; ++j) {
            const std::size_t row = static_cast<std::size_t>(k) * rows_per_slice + static_cast<std::size_t>(j);
            std::fill(bend.begin(), bend.end(), 0.0F);
            relief.add_row(j, k, 0.09F, bend.data());
            const float y = from_centre(j, size.y), z = from_centre(k, size.z);
            for (int i = 0; i < size.x; ++i) {
                const float x = from_centre(i, size.x);
                const float r = std::sqrt(x * x + y * y + z * z) + bend[static_cast<std::size_t>(i)];
                float nearest = 1.0F;
                for (const float radius : radii)
                    nearest = std::min(nearest, std::fabs(r - radius));
                const float density = std::max(1.0F - nearest / thickness, 0.0F);
                const auto voxel = static_cast<std::uint8_t>(std::lrint(255.0F * density));
                voxels[row * row_length + static_cast<std::size_t>(i)] = voxel;
                row_sums[row] += voxel;
            }
        }
    });
    double sum = 0.0;
    const auto met = std::count_if(row_sums.begin(), row_sums.end(), [](double s) { return s > 0.0; });
    for (const double s : row_sums)
        sum += s;
    const double voxel_world = 256.0 / size.x;
    const double extinction = mean_optical_depth * 255.0 * static_cast<double>(met) / (sum * voxel_world);
    specimen.transfer_function =
        TransferFunction({{0.0, 0.0, {0.8, 0.7, 0.6}}, {255.0, extinction, {0.95, 0.9, 0.85}}});
    return specimen;
}

} // namespace lumisweep::bench
