// Lumisweep inside another program: wrap an array, render 16 samples a pixel, write an OpenEXR image.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "lumisweep/lumisweep.h"

using namespace lumisweep;

/// A torus of density 0 … 1000 in n³ voxels.
std::vector<std::int16_t> torus(int n)
{
    std::vector<std::int16_t> density;
    for (int k = 0; k < n; ++k)
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const double x = 2.0 * i / n - 1.0, y = 2.0 * j / n - 1.0, z = 2.0 * k / n - 1.0;
                const double ring = std::hypot(std::hypot(x, z) - 0.6, y);
                density.push_back(static_cast<std::int16_t>(1000.0 * std::fmax(0.0, 1.0 - ring / 0.3)));
            }
    return density;
}

int main(int argc, char** argv)
{
    try {
        constexpr int n = 64;
        const std::vector<std::int16_t> array = torus(n);

        Affine3d world_from_voxel; // voxels of 1 mm, the volume's corner at the origin
        auto volume = std::make_shared<ScalarGrid>(VoxelType::i16, Vec3i{n, n, n}, world_from_voxel);
        std::copy(array.begin(), array.end(), volume->voxels<std::int16_t>());

        SessionInput input;
        input.transfer_function = TransferFunction({{100, 0.0, {0.9, 0.8, 0.7}}, {600, 1.5, {0.9, 0.8, 0.7}}});
        input.environment = std::make_shared<Environment>(environment_from_sky({}));
        input.image = {256, 256, true};
        const VoxelBox box = visible_box(*volume, input.transfer_function, value_statistics(*volume));
        input.camera = frame_camera({}, *volume, box, input.image);
        input.volume = volume;

        Session session(std::move(input), make_cpu_backend());
        while (session.film().samples() < 16)
            session.render_pass();
        write_exr(argc > 1 ? argv[1] : "embed.exr", session.film().to_image());
        std::printf("noise after %d samples: %.3f\n", static_cast<int>(session.film().samples()),
                    session.film().noise());
        return 0;
    } catch (const Error& error) {
        std::fprintf(stderr, "embed: %s\n", error.what());
        return 1;
    }
}
