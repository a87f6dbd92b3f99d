#include "lumisweep/visibility/extinction_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include <tbb/enumerable_thread_specific.h>

#include "lumisweep/base/error.h"
#include "lumisweep/base/parallel.h"

namespace lumisweep {
namespace {

// Stored extinction in 16.16 fixed point; adding 16 random bits before the shift rounds up as often as the fraction
// says.
constexpr double fixed_one = 65536.0;

/// 16 bits that depend on nothing but the voxel's index, so that the result is the same for any number of threads.
inline std::uint32_t dither_bits(std::uint32_t index)
{
    std::uint32_t h = index * 0x9e3779b1U;
    h ^= h >> 15;
    h *= 0x85ebca77U;
    h ^= h >> 13;
    h *= 0xc2b2ae3dU;
    return h >> 16;
}

inline std::uint8_t dithered(std::uint32_t fixed, std::uint32_t index)
{
    return static_cast<std::uint8_t>((fixed + dither_bits(index)) >> 16);
}

std::uint32_t to_fixed(double extinction, double scale)
{
    return static_cast<std::uint32_t>(std::lround(std::min(extinction / scale, 255.0) * fixed_one));
}

std::size_t count(Vec3i size)
{
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z);
}

/// Calls body(first, last) for ranges of voxel indices, one slice of the volume each.
template <class Body>
void parallel_slices(Vec3i size, Body&& body)
{
    const std::size_t slice = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
    parallel_for(0, size.z,
                 [&](int k) { body(static_cast<std::size_t>(k) * slice, (static_cast<std::size_t>(k) + 1) * slice); });
}

/// 8 and 16 bits: the transfer function is evaluated once for each raw value that occurs.
template <class T>
float classify_integers(const T* voxels, const ScalarGrid& volume, const TransferFunction& tf, std::uint8_t* stored)
{
    constexpr int low = std::numeric_limits<T>::min();
    static constexpr std::size_t values = std::size_t{1} << (8 * sizeof(T));
    using Flags = std::vector<std::uint8_t>;
    tbb::enumerable_thread_specific<Flags> flags_of_thread(Flags(values, 0)); // copied to each thread
    parallel_slices(volume.size(), [&](std::size_t first, std::size_t last) {
        std::uint8_t* flags = flags_of_thread.local().data();
        for (std::size_t i = first; i < last; ++i)
            flags[static_cast<int>(voxels[i]) - low] = 1;
    });

    std::vector<double> extinction(values, 0.0);
    double largest = 0.0;
    for (const Flags& flags : flags_of_thread)
        for (std::size_t r = 0; r < values; ++r)
            if (flags[r]) {
                extinction[r] =
                    tf.evaluate(volume.slope() * (static_cast<int>(r) + low) + volume.intercept()).extinction;
                largest = std::max(largest, extinction[r]);
            }
    if (!(largest > 0.0))
        return 0.0F;

    const double scale = largest / 255.0;
    std::vector<std::uint32_t> table(values);
    std::transform(extinction.begin(), extinction.end(), table.begin(), [&](double e) { return to_fixed(e, scale); });
    parallel_slices(volume.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i)
            stored[i] = dithered(table[static_cast<std::size_t>(static_cast<int>(voxels[i]) - low)],
                                 static_cast<std::uint32_t>(i));
    });
    return static_cast<float>(scale);
}

float classify_floats(const float* voxels, const ScalarGrid& volume, const TransferFunction& tf, std::uint8_t* stored)
{
    // Runs of equal values, above all empty space, are evaluated once.
    const auto for_each_extinction = [&](std::size_t first, std::size_t last, auto&& use) {
        float previous = std::numeric_limits<float>::quiet_NaN();
        double extinction = 0.0;
        for (std::size_t i = first; i < last; ++i) {
            if (voxels[i] != previous) {
                previous = voxels[i];
                extinction =
                    std::isfinite(previous)
                        ? tf.evaluate(volume.slope() * static_cast<double>(previous) + volume.intercept()).extinction
                        : 0.0;
            }
            use(i, extinction);
        }
    };

    tbb::enumerable_thread_specific<double> largest_of_thread(0.0);
    parallel_slices(volume.size(), [&](std::size_t first, std::size_t last) {
        double& largest = largest_of_thread.local();
        for_each_extinction(first, last, [&](std::size_t, double e) { largest = std::max(largest, e); });
    });
    const double largest = largest_of_thread.combine([](double a, double b) { return std::max(a, b); });
    if (!(largest > 0.0))
        return 0.0F;

    const double scale = largest / 255.0;
    parallel_slices(volume.size(), [&](std::size_t first, std::size_t last) {
        for_each_extinction(first, last, [&](std::size_t i, double e) {
            stored[i] = dithered(to_fixed(e, scale), static_cast<std::uint32_t>(i));
        });
    });
    return static_cast<float>(scale);
}

/// Averages 2³ voxels. Voxels missing at an odd end count as empty, so that extinction × length is kept.
ExtinctionGrid half_resolution(const ExtinctionGrid& fine)
{
    ExtinctionGrid coarse;
    coarse.size = {(fine.size.x + 1) / 2, (fine.size.y + 1) / 2, (fine.size.z + 1) / 2};
    coarse.stored = AlignedArray<std::uint8_t>(count(coarse.size));
    const std::size_t fine_x = static_cast<std::size_t>(fine.size.x),
                      coarse_x = static_cast<std::size_t>(coarse.size.x);
    parallel_for(0, coarse.size.z, [&](int k) {
        std::vector<std::uint32_t> sums(2 * coarse_x);
        for (int j = 0; j < coarse.size.y; ++j) {
            std::fill(sums.begin(), sums.end(), 0U);
            for (int dk = 2 * k; dk < std::min(2 * k + 2, fine.size.z); ++dk)
                for (int dj = 2 * j; dj < std::min(2 * j + 2, fine.size.y); ++dj) {
                    const std::size_t row = static_cast<std::size_t>(dk) * static_cast<std::size_t>(fine.size.y) +
                                            static_cast<std::size_t>(dj);
                    const std::uint8_t* source = fine.stored.data() + row * fine_x;
                    for (std::size_t i = 0; i < fine_x; ++i)
                        sums[i] += source[i];
                }
            const std::size_t row =
                static_cast<std::size_t>(k) * static_cast<std::size_t>(coarse.size.y) + static_cast<std::size_t>(j);
            for (std::size_t i = 0; i < coarse_x; ++i) {
                const std::size_t index = row * coarse_x + i;
                coarse.stored[index] =
                    dithered((sums[2 * i] + sums[2 * i + 1]) * 8192U, static_cast<std::uint32_t>(index));
            }
        }
    });
    return coarse;
}

} // namespace

std::size_t ExtinctionPyramid::bytes() const
{
    std::size_t sum = 0;
    for (const ExtinctionGrid& level : levels)
        sum += level.stored.bytes();
    return sum;
}

ExtinctionPyramid classify(const ScalarGrid& volume, const TransferFunction& transfer_function, int mip_level)
{
    require(mip_level >= 0 && mip_level <= 13, "classify: mip level {} (use 0 to 13)", mip_level);
    ExtinctionPyramid pyramid;
    pyramid.world_from_voxel = volume.world_from_voxel();
    pyramid.levels.resize(1);
    pyramid.levels[0].size = volume.size();
    pyramid.levels[0].stored = AlignedArray<std::uint8_t>(count(volume.size()));
    std::uint8_t* stored = pyramid.levels[0].stored.data();
    pyramid.scale = visit_voxels(volume, [&](const auto* voxels) {
        if constexpr (std::is_same_v<decltype(voxels), const float*>)
            return classify_floats(voxels, volume, transfer_function, stored);
        else
            return classify_integers(voxels, volume, transfer_function, stored);
    });
    for (int level = 1; level <= mip_level; ++level)
        pyramid.levels.push_back(half_resolution(pyramid.levels.back()));
    return pyramid;
}

} // namespace lumisweep
