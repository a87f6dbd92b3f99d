// Sweeps of all kinds, small enough for slow versions of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <ostream>
#include <random>
#include <vector>

#include "generated_volumes.h"
#include "lumisweep/visibility/sweep.h"
#include "stored_voxels.h"

namespace lumisweep::test {

/// A sweep made from its number alone.
struct SweepCase {
    std::uint32_t number;
    std::mt19937 random;
    VisibilitySettings settings;
    ExtinctionGrid extinction;
    std::vector<int> compared; // directions
    std::vector<int> subset;   // some of them, and others

    explicit SweepCase(std::uint32_t case_number) : number(case_number), random(case_number)
    {
        const int kind = integer(0, 9);
        settings.directions = pick({1, 2, 4, 4, 8, 8, 8, 16, 32});
        settings.cell = pick({1, 1, 2, 2, 3, 4, 4, 4, 5, 6, 7, 8, 8, 9, 13, 64});
        settings.filter = pick({SweepFilter::none, SweepFilter::half_angle, SweepFilter::full_angle});
        settings.oversampling = kind == 0 ? pick({4, 16}) : 1;
        const int longest = kind == 0 ? 30 : settings.cell == 1 ? 41 : 71;
        const auto side = [&] { return integer(0, 5) == 0 ? integer(1, 3) : integer(1, longest); };
        extinction.volume_size = {side(), side(), side()};
        if (kind == 1) { // many strips
            const auto short_side = [&] { return integer(1, 16); };
            extinction.volume_size = {short_side(), short_side(), short_side()};
            Vec3i& size = extinction.volume_size;
            *pick({&size.x, &size.y, &size.z}) = integer(100, 300);
        }
        if (integer(0, 3) == 0) { // cells of a whole number of voxels
            Vec3i& size = extinction.volume_size;
            const auto whole = [&](int n) { return std::max(n / settings.cell, 1) * settings.cell; };
            size = {whole(size.x), whole(size.y), whole(size.z)};
        }
        const Vec3i size = extinction.volume_size;
        settings.rays = 8192;
        int left = std::max({size.x, size.y, size.z});
        for (int halvings = pick({0, 0, 0, 1, 1, 2, 3}); halvings > 0; --halvings)
            settings.rays = left = std::max((left + 1) / 2, 1);
        extinction.mip_level = sweep_mip_level(size, settings.rays);
        const auto level_side = [&](int n) { return (n + (1 << extinction.mip_level) - 1) >> extinction.mip_level; };
        extinction.size = {level_side(size.x), level_side(size.y), level_side(size.z)};
        place();
        fill();
        const int n = settings.directions * settings.directions;
        for (int i = 0; i < (settings.oversampling == 16 ? 2 : 6); ++i)
            compared.push_back(integer(0, n - 1));
        subset = compared;
        for (int i = 0; i < 4; ++i)
            subset.push_back(integer(0, n - 1));
    }

    int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); }
    double real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
    template <class T>
    T pick(std::initializer_list<T> from)
    {
        return from.begin()[integer(0, static_cast<int>(from.size()) - 1)];
    }

    void place()
    {
        Affine3d& world = extinction.world_from_voxel;
        switch (integer(0, 3)) {
        case 0: break;
        case 1: world = spaced({real(0.3, 3.0), real(0.3, 3.0), real(0.3, 3.0)}); break;
        case 2: world = oblique(); break;
        default: // sheared and mirrored somehow, but with a volume
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto s = [&] { return real(-0.35, 0.35); };
                Vec3d column{s(), s(), s()};
                (axis == 0 ? column.x : axis == 1 ? column.y : column.z) = pick({-1.0, 1.0}) * real(0.8, 1.6);
                world.column[axis] = column;
            }
        }
    }

    void fill()
    {
        const Vec3i& size = extinction.size;
        // Constant, rare voxels, noise in a part of the box, noise.
        const int kind = integer(0, 4), rare = integer(1, 200);
        const Vec3i low{integer(0, size.x - 1), integer(0, size.y - 1), integer(0, size.z - 1)};
        const Vec3i high{integer(low.x, size.x), integer(low.y, size.y), integer(low.z, size.z)};
        store_voxels(extinction, pick({FilledIn::voxels, FilledIn::lines}), [&](int i, int j, int k) {
            const bool inside = i >= low.x && i < high.x && j >= low.y && j < high.y && k >= low.z && k < high.z;
            switch (kind) {
            case 0: return 255;
            case 1: return integer(0, rare) == 0 ? 255 : 0;
            case 2: return inside ? integer(0, 255) : 0;
            default: return integer(0, 255);
            }
        });
        // Optical depths about 1, to the far end or less far.
        const double mean = kind == 1 ? 255.0 / (rare + 1) : 128.0;
        extinction.scale = static_cast<float>(real(0.3, 10.0) / (mean * std::max({size.x, size.y, size.z})));
    }
};

inline std::ostream& operator<<(std::ostream& out, const SweepCase& c)
{
    const Vec3i size = c.extinction.volume_size;
    return out << "case " << c.number << ": " << size.x << " x " << size.y << " x " << size.z << " voxels, cell "
               << c.settings.cell << ", directions " << c.settings.directions << ", mip level "
               << c.extinction.mip_level << ", filter " << static_cast<int>(c.settings.filter) << ", oversampling "
               << c.settings.oversampling;
}

} // namespace lumisweep::test
