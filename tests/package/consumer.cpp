// Renders a small fog cube through the installed library and prints the mean coverage of the image.
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <utility>
#include <vector>

#include <lumisweep/backends/cpu/cpu_backend.h>
#include <lumisweep/render/session.h>

int main()
try {
    using namespace lumisweep;
    Affine3d world_from_voxel;
    auto fog = std::make_shared<ScalarGrid>(VoxelType::u8, Vec3i{16, 16, 16}, world_from_voxel);
    for (std::size_t i = 0; i < fog->voxel_count(); ++i)
        fog->voxels<unsigned char>()[i] = 1;

    SessionInput input;
    input.volume = fog;
    input.transfer_function = TransferFunction({{0.0, 0.0, {1.0, 1.0, 1.0}}, {1.0, 0.2, {1.0, 1.0, 1.0}}});
    input.environment = std::make_shared<Environment>(Environment::constant({1.0, 1.0, 1.0}));
    input.camera.position = {8.0, -40.0, 8.0};
    input.camera.target = {8.0, 8.0, 8.0};
    input.camera.vertical_fov_deg = 5.0; // inside the cube's outline: every ray crosses 16 units of fog
    input.image.width = input.image.height = 32;

    Session session(std::move(input), make_cpu_backend());
    for (int pass = 0; pass < 64; ++pass)
        session.render_pass();

    double coverage = 0.0;
    const Image image = session.film().to_image();
    const std::vector<float>& alpha = image.find("A")->pixels;
    for (const float a : alpha)
        coverage += a / static_cast<double>(alpha.size());
    const double expected = 1.0 - std::exp(-0.2 * 16.0);
    std::printf("coverage %.4f, expected %.4f\n", coverage, expected);
    return std::abs(coverage - expected) < 0.005 ? 0 : 1;
} catch (const std::exception& error) {
    std::fprintf(stderr, "consumer: %s\n", error.what());
    return 1;
}
