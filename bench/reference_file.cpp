#include "reference_file.h"

#include <array>

#include "lumisweep/base/error.h"
#include "lumisweep/image/exr.h"

namespace lumisweep::bench {
namespace {

constexpr std::array<const char*, 3> color_names{"R", "G", "B"}, albedo_names{"albedo.R", "albedo.G", "albedo.B"};

} // namespace

void write_reference(const std::filesystem::path& file, const Reference& reference)
{
    Image image;
    image.width = reference.width;
    image.height = reference.height;
    const std::size_t pixels = reference.covered.size();
    const auto add = [&](const char* name, const std::vector<float>& from, std::size_t stride, std::size_t first) {
        Channel channel{name, std::vector<float>(pixels)};
        for (std::size_t p = 0; p < pixels; ++p)
            channel.pixels[p] = from[stride * p + first];
        image.channels.push_back(std::move(channel));
    };
    for (std::size_t c = 0; c < 3; ++c) {
        add(color_names[c], reference.color, 3, c);
        add(albedo_names[c], reference.albedo, 3, c);
    }
    add("A", reference.covered, 1, 0);
    image.numbers["ownMse"] = reference.own_mse;
    image.numbers["meanError"] = reference.mean_error;
    write_exr(file, image);
}

Reference read_reference(const std::filesystem::path& file)
{
    const Image image = read_exr(file);
    Reference reference;
    reference.width = image.width;
    reference.height = image.height;
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    const auto take = [&](const char* name, std::vector<float>& into, std::size_t stride, std::size_t first) {
        const Channel* channel = image.find(name);
        require(channel != nullptr && image.numbers.contains("ownMse") && image.numbers.contains("meanError"),
                "{}: is no reference (remove it)", file.string());
        into.resize(stride * pixels);
        for (std::size_t p = 0; p < pixels; ++p)
            into[stride * p + first] = channel->pixels[p];
    };
    for (std::size_t c = 0; c < 3; ++c) {
        take(color_names[c], reference.color, 3, c);
        take(albedo_names[c], reference.albedo, 3, c);
    }
    take("A", reference.covered, 1, 0);
    reference.own_mse = image.numbers.at("ownMse");
    reference.mean_error = image.numbers.at("meanError");
    return reference;
}

} // namespace lumisweep::bench
