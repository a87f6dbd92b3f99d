#include "volumes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "lattice_noise.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/volume/io/load_volume.h"

namespace lumisweep::bench {
namespace {

/// −1 … 1 over the volume.
float centred(int i, int size) { return (2.0F * static_cast<float>(i) + 1.0F) / static_cast<float>(size) - 1.0F; }

/// 1 where x is well below 0, 0 well above, and a ramp of `width` between: a surface as a scanner blurs it.
float below(float x, float width) { return std::clamp(0.5F - x / width, 0.0F, 1.0F); }

float mix(float a, float b, float t) { return a + (b - a) * t; }

/// Calls row(j, k, voxels) for every row of the grid.
template <class Row>
void fill_rows(ScalarGrid& grid, Row&& row)
{
    const Vec3i size = grid.size();
    std::int16_t* voxels = grid.voxels<std::int16_t>();
    parallel_for(0, size.z, [&](int k) {
        for (int j = 0; j < size.y; ++j)
            row(j, k,
                voxels +
                    (static_cast<std::size_t>(k) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(j)) *
                        static_cast<std::size_t>(size.x));
    });
}

std::int16_t to_i16(float x) { return static_cast<std::int16_t>(std::lrint(std::clamp(x, -1024.0F, 3071.0F))); }

/// Vessels: tubes that wind up through the head, their centres given per height.
struct Vessel {
    float x, y, sway, turns, phase, radius;
};
constexpr std::array<Vessel, 9> vessels{{{0.25F, -0.10F, 0.12F, 2.1F, 0.3F, 0.014F},
                                         {-0.25F, -0.12F, 0.12F, 2.3F, 2.6F, 0.014F},
                                         {0.02F, 0.12F, 0.05F, 3.2F, 1.0F, 0.018F},
                                         {0.38F, 0.25F, 0.14F, 2.7F, 4.1F, 0.010F},
                                         {-0.38F, 0.22F, 0.15F, 2.5F, 5.5F, 0.010F},
                                         {0.12F, -0.45F, 0.09F, 4.4F, 0.9F, 0.009F},
                                         {-0.14F, -0.42F, 0.10F, 4.1F, 3.4F, 0.009F},
                                         {0.08F, 0.55F, 0.10F, 1.6F, 2.0F, 0.016F},
                                         {-0.48F, -0.05F, 0.08F, 5.2F, 1.7F, 0.008F}}};

float squared(float x) { return x * x; }

/// Twice the voxels along each axis, in steps of `step` from `low`.
template <class Voxel>
void double_voxels(const Voxel* in, Vec3i from, int step, int low, std::uint8_t* out)
{
    const auto nx = static_cast<std::size_t>(from.x), ny = static_cast<std::size_t>(from.y);
    // A fine voxel lies a quarter of a coarse one to either side of its centre: weights 3/4 and 1/4 along each axis.
    const auto neighbours = [](int i, int count) {
        return std::array<std::size_t, 2>{
            static_cast<std::size_t>(i / 2),
            static_cast<std::size_t>(std::clamp(i / 2 + (i % 2 == 0 ? -1 : 1), 0, count - 1))};
    };
    const auto rounded = [step](int sum) {
        return static_cast<std::uint8_t>(std::min((sum + 32 * step) / (64 * step), 255));
    };
    parallel_for(0, 2 * from.z, [&](int k) {
        const auto z = neighbours(k, from.z);
        std::vector<int> row(nx);
        for (int j = 0; j < 2 * from.y; ++j) {
            const auto y = neighbours(j, from.y);
            const Voxel *r00 = in + (z[0] * ny + y[0]) * nx, *r10 = in + (z[0] * ny + y[1]) * nx;
            const Voxel *r01 = in + (z[1] * ny + y[0]) * nx, *r11 = in + (z[1] * ny + y[1]) * nx;
            for (std::size_t i = 0; i < nx; ++i)
                row[i] = 9 * r00[i] + 3 * r10[i] + 3 * r01[i] + r11[i] - 16 * low;
            std::uint8_t* line = out + (static_cast<std::size_t>(k) * 2 * ny + static_cast<std::size_t>(j)) * 2 * nx;
            for (std::size_t i = 0; i < nx; ++i) {
                const int before = row[i == 0 ? 0 : i - 1], after = row[i + 1 == nx ? i : i + 1];
                line[2 * i] = rounded(3 * row[i] + before);
                line[2 * i + 1] = rounded(3 * row[i] + after);
            }
        }
    });
}

} // namespace

Affine3d centred_box(Vec3i size)
{
    const double side = 256.0 / size.x;
    Affine3d a;
    for (Vec3d& column : a.column)
        column = column * side;
    a.offset =
        Vec3d{static_cast<double>(size.x), static_cast<double>(size.y), static_cast<double>(size.z)} * (-0.5 * side);
    return a;
}

Specimen ct_like(Vec3i size)
{
    const int side = std::max({size.x, size.y, size.z});
    const LatticeNoise shape(size, 0.25 * side, 2, 0.5, 1), trabeculae(size, std::max(2.0, side / 64.0), 2, 0.6, 2);
    const LatticeNoise walls(size, std::max(3.0, side / 22.0), 2, 0.4, 3), scanner(size, 2.0, 1, 1.0, 4);
    Specimen specimen{"ct", ScalarGrid(VoxelType::i16, size, centred_box(size)),
                      TransferFunction({{180.0, 0.0}, {320.0, 0.8}, {500.0, 3.0}, {1500.0, 6.0}})};
    const float voxel = 2.0F / static_cast<float>(size.x), blur = 1.5F * voxel;
    fill_rows(specimen.volume, [&](int j, int k, std::int16_t* out) {
        const auto count = static_cast<std::size_t>(size.x);
        std::vector<float> bend(count), spongy(count), wall(count), noise(count);
        shape.add_row(j, k, 0.03F, bend.data());
        trabeculae.add_row(j, k, 1.0F, spongy.data());
        walls.add_row(j, k, 1.0F, wall.data());
        scanner.add_row(j, k, 22.0F, noise.data());
        // The scan ends below the ears, as most do: light comes in from below.
        const float y = centred(j, size.y), z = (centred(k, size.z) + 0.3F) / 1.3F;
        for (int i = 0; i < size.x; ++i) {
            const auto at = static_cast<std::size_t>(i);
            const float x = centred(i, size.x);
            const float d = std::sqrt(squared(x / 0.80F) + squared(y / 0.95F) + squared(z / 0.97F)) - 0.88F + bend[at];
            // From outside to inside: air, skin and muscle, outer table, spongy bone, inner table, brain.
            float hu = mix(-1000.0F, 45.0F + 12.0F * spongy[at], below(d - 0.065F, blur));
            const float spongy_bone = 420.0F + 380.0F * spongy[at];
            const float in_bone = below(d - 0.012F, blur) * (1.0F - below(d + 0.052F, blur));
            const float in_sponge = below(d + 0.004F, blur) * (1.0F - below(d + 0.036F, blur));
            float bone = mix(1350.0F, spongy_bone, in_sponge);
            // Orbits and the hole of the spine interrupt the skull.
            const float orbit = std::sqrt(squared((std::fabs(x) - 0.30F) / 0.19F) + squared((y + 0.82F) / 0.30F) +
                                          squared((z - 0.02F) / 0.17F)) -
                                1.0F;
            const float spine = std::hypot(x, y - 0.18F) - (z < -0.5F ? 0.13F : -1.0F);
            const float open = std::max(below(orbit, 4.0F * blur), below(spine, blur));
            hu = mix(hu, mix(bone, 30.0F, open), in_bone);
            hu = mix(hu, 1100.0F, below(std::fabs(orbit) - 0.04F, 4.0F * blur) * (d < 0.03F ? 1.0F : 0.0F));
            // Sinuses and mastoid cells: air behind walls as thin as a voxel, where the noise passes zero.
            const float sinus =
                std::sqrt(squared(x / 0.24F) + squared((y + 0.60F) / 0.24F) + squared((z + 0.22F) / 0.30F)) - 1.0F;
            const float mastoid = std::sqrt(squared((std::fabs(x) - 0.58F) / 0.12F) + squared((y - 0.10F) / 0.16F) +
                                            squared((z + 0.34F) / 0.18F)) -
                                  1.0F;
            const float cavity = std::min(sinus, mastoid);
            if (cavity < 0.1F) {
                const float cell = mix(-950.0F, 950.0F, below(std::fabs(wall[at]) - 0.05F, 0.12F));
                hu = mix(hu, mix(cell, 1000.0F, below(-0.12F - cavity, 0.1F) * below(cavity, 0.1F)),
                         below(cavity, 0.1F));
            }
            if (d < -0.05F)
                for (const Vessel& v : vessels) {
                    const float distance = std::hypot(x - v.x - v.sway * std::sin(v.turns * 3.0F * z + v.phase),
                                                      y - v.y - v.sway * std::cos(v.turns * 2.3F * z + v.phase));
                    hu = mix(hu, 380.0F, below(distance - v.radius, blur));
                }
            out[i] = to_i16(hu + noise[at]);
        }
    });
    return specimen;
}

Specimen smoke_like(Vec3i size)
{
    const int side = std::max({size.x, size.y, size.z});
    const LatticeNoise billows(size, side / 5.0, 6, 0.55, 11), drift(size, side / 2.0, 2, 0.5, 12);
    Specimen specimen{"smoke", ScalarGrid(VoxelType::i16, size, centred_box(size)),
                      TransferFunction({{0.0, 0.0}, {1000.0, 0.06}})};
    fill_rows(specimen.volume, [&](int j, int k, std::int16_t* out) {
        const auto count = static_cast<std::size_t>(size.x);
        std::vector<float> density(count), shift(count);
        billows.add_row(j, k, 1.0F, density.data());
        drift.add_row(j, k, 0.25F, shift.data());
        const float y = centred(j, size.y), z = centred(k, size.z);
        for (int i = 0; i < size.x; ++i) {
            const auto at = static_cast<std::size_t>(i);
            const float x = centred(i, size.x) + shift[at];
            // A column that widens upwards.
            const float envelope = 1.0F - std::hypot(x, y - 0.6F * shift[at]) / (0.55F + 0.30F * z) - 0.5F * z * z;
            out[i] = to_i16(1000.0F * std::clamp(envelope + 0.75F * density[at], 0.0F, 1.5F));
        }
    });
    return specimen;
}

std::optional<Specimen> ch2better(const std::filesystem::path& data)
{
    const std::filesystem::path file = data / "ch2better.nii.gz";
    if (!std::filesystem::exists(file))
        return std::nullopt;
    // As scenes/ch2.json: translucent, the fat of the skin left out.
    return Specimen{"ch2better", load_volume({{file}}).grid,
                    TransferFunction({{60.0, 0.0}, {90.0, 0.2}, {120.0, 0.8}, {126.0, 0.0}})};
}

Specimen doubled(const Specimen& specimen)
{
    const ScalarGrid& coarse = specimen.volume;
    const Vec3i from = coarse.size(), size{2 * from.x, 2 * from.y, 2 * from.z};
    Affine3d world_from_voxel = coarse.world_from_voxel();
    for (Vec3d& column : world_from_voxel.column)
        column = column * 0.5;
    // 16 data units a step hold −1024 … 3071; bytes stay as they are.
    constexpr int step = 16, low = -1024;
    const bool bytes = coarse.type() == VoxelType::u8;
    Specimen fine{specimen.name + "-doubled",
                  ScalarGrid(VoxelType::u8, size, world_from_voxel, bytes ? coarse.slope() : step,
                             bytes ? coarse.intercept() : low),
                  specimen.transfer_function};
    std::uint8_t* out = fine.volume.voxels<std::uint8_t>();
    if (bytes)
        double_voxels(coarse.voxels<std::uint8_t>(), from, 1, 0, out);
    else
        double_voxels(coarse.voxels<std::int16_t>(), from, step, low, out);
    return fine;
}

} // namespace lumisweep::bench
