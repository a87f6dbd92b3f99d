#include "lumisweep/scene/fingerprint.h"

#include <initializer_list>
#include <vector>

#include <fmt/format.h>

#include "lumisweep/scene/hash.h"

namespace lumisweep {

namespace {

std::uint64_t hash_numbers(std::initializer_list<double> numbers, std::uint64_t seed = 0)
{
    return hash_bytes(numbers.begin(), numbers.size() * sizeof(double), seed);
}

std::uint64_t hash_of(const ScalarGrid& volume)
{
    const Affine3d& map = volume.world_from_voxel();
    std::uint64_t h = hash_bytes(volume.data(), volume.bytes());
    h = hash_numbers({static_cast<double>(volume.type()), static_cast<double>(volume.size().x),
                      static_cast<double>(volume.size().y), static_cast<double>(volume.size().z), volume.slope(),
                      volume.intercept()},
                     h);
    for (const Vec3d& v : {map.column[0], map.column[1], map.column[2], map.offset})
        h = hash_numbers({v.x, v.y, v.z}, h);
    return h;
}

std::uint64_t hash_of(const TransferFunction& transfer_function)
{
    std::uint64_t h = hash_numbers({transfer_function.extinction_scale()});
    for (const TransferPoint& point : transfer_function.points())
        h = hash_numbers({point.value, point.extinction, point.albedo.x, point.albedo.y, point.albedo.z}, h);
    return h;
}

std::uint64_t hash_of(const Environment& environment)
{
    const auto n = static_cast<std::size_t>(environment.resolution());
    return hash_bytes(environment.view().radiance, 3 * n * n * sizeof(float));
}

std::uint64_t hash_of(const Camera& camera)
{
    std::uint64_t h = 0;
    for (const Vec3d& v : {camera.position, camera.target, camera.up})
        h = hash_numbers({v.x, v.y, v.z}, h);
    return hash_numbers({camera.vertical_fov_deg, camera.lens_radius, camera.focus_distance}, h);
}

std::uint64_t hash_of(const VisibilitySettings& visibility)
{
    return hash_numbers({static_cast<double>(visibility.directions), static_cast<double>(visibility.cell),
                         static_cast<double>(visibility.rays), static_cast<double>(visibility.filter),
                         static_cast<double>(visibility.oversampling), visibility.epsilon});
}

} // namespace

Fingerprint fingerprint_of(const SessionInput& input, const std::string& isa, const std::string& program_version)
{
    const RenderSettings render = input.render.resolved();
    return {
        {"program version", program_version},
        {"instruction set", isa},
        {"volume", hex(hash_of(*input.volume))},
        {"transfer function", hex(hash_of(input.transfer_function))},
        {"environment", hex(hash_of(*input.environment))},
        {"camera", hex(hash_of(input.camera))},
        {"image size", fmt::format("{} x {}", input.image.width, input.image.height)},
        {"show_environment", input.image.show_environment ? "true" : "false"},
        {"strategy", name_of(input.render.strategy)},
        {"random_numbers", render.random_numbers == RandomNumbers::stratified ? "stratified" : "independent"},
        {"shadow_rays", std::to_string(render.shadow_rays)},
        {"seed", std::to_string(input.render.seed)},
        {"visibility settings", hex(hash_of(input.visibility))},
    };
}

std::string difference(const Fingerprint& found, const Fingerprint& expected)
{
    std::vector<std::string> differing;
    for (const auto& [name, value] : expected) {
        const auto other = found.find(name);
        const bool hashed = value.size() == 16;
        if (other == found.end())
            differing.push_back(name);
        else if (other->second != value)
            differing.push_back(hashed ? name : fmt::format("{} ({}, not {})", name, other->second, value));
    }
    return fmt::format("{}", fmt::join(differing, ", "));
}

} // namespace lumisweep
