#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "info.h"
#include "lumisweep/base/memory.h"

namespace lumisweep::cli {

namespace {

using nlohmann::ordered_json;

void line(const char* label, const std::string& text) { fmt::print("{:<14}{}\n", label, text); }

std::string joined(const ordered_json& numbers, const char* separator)
{
    std::string text;
    for (const ordered_json& number : numbers)
        text += (text.empty() ? "" : separator) + fmt::format("{:.6g}", number.get<double>());
    return text;
}

void print_histogram(const ordered_json& histogram)
{
    std::uint64_t largest = 1;
    for (const ordered_json& count : histogram["counts"])
        largest = std::max(largest, count.get<std::uint64_t>());
    fmt::print("histogram\n");
    double low = histogram["low"].get<double>();
    for (const ordered_json& count : histogram["counts"]) {
        // A cube root, so that a few bright voxels still show beside all the air.
        const double share = std::cbrt(count.get<double>() / static_cast<double>(largest));
        fmt::print("{:>12.6g}  {:<40}  {}\n", low, std::string(static_cast<std::size_t>(share * 40.0), '#'),
                   count.get<std::uint64_t>());
        low += histogram["bin_width"].get<double>();
    }
}

void print_geometry(const ordered_json& info)
{
    line("format", info["format"].get<std::string>());
    line("modality", info["modality"].get<std::string>().empty() ? "unknown" : info["modality"].get<std::string>());
    line("size", joined(info["size"], " x ") + " voxels, " + info["voxel_type"].get<std::string>());
    line("frames", info["frames"].dump());
    line("spacing", joined(info["spacing"], " x ") + " mm");
    line("orientation", fmt::format("{} (x [{}], y [{}], z [{}])", info["orientation"].get<std::string>(),
                                    joined(info["directions"][0], ", "), joined(info["directions"][1], ", "),
                                    joined(info["directions"][2], ", ")));
    line("first voxel", fmt::format("[{}]", joined(info["first_voxel_centre"], ", ")));
    line("values", fmt::format("{:g} * stored + {:g}", info["slope"].get<double>(), info["intercept"].get<double>()));
}

} // namespace

void print_volume(const ordered_json& info)
{
    line("volume", info["path"].get<std::string>());
    print_geometry(info);
    line("memory", format_bytes(info["memory_bytes"].get<std::uint64_t>()));
    line("range",
         fmt::format("{:.6g} to {:.6g}, {} not finite (frame {})", info["min"].get<double>(), info["max"].get<double>(),
                     info["non_finite"].get<std::uint64_t>(), info["frame"].get<int>()));
    std::string percentiles;
    for (const auto& item : info["percentiles"].items())
        percentiles += fmt::format("{}%: {:.6g}  ", item.key(), item.value().get<double>());
    line("percentiles", percentiles);
    line("preset", info["preset"].get<std::string>());
    for (const ordered_json& warning : info["warnings"])
        line("warning", warning.get<std::string>());
    print_histogram(info["histogram"]);
}

void print_environment(const ordered_json& info)
{
    line("environment", info["path"].get<std::string>());
    line("size", joined(info["size"], " x ") + " pixels");
    line("octahedral", fmt::format("{0} x {0} texels, {1}", info["octahedral_resolution"].get<int>(),
                                   format_bytes(info["memory_bytes"].get<std::uint64_t>())));
    line("luminance", fmt::format("mean {:.6g}, largest {:.6g}", info["mean_luminance"].get<double>(),
                                  info["max_luminance"].get<double>()));
    line("contrast", fmt::format("E[L^2] / E[L]^2 = {:.4g}", info["contrast"].get<double>()));
    line("concentration", fmt::format("{:.1f} % of the power from the brightest thousandth of the sphere",
                                      100.0 * info["power_in_brightest_thousandth"].get<double>()));
    line("clamped", fmt::format("{} negative and {} non-finite texels", info["negative_texels"].get<std::uint64_t>(),
                                info["non_finite_texels"].get<std::uint64_t>()));
}

void print_scene(const ordered_json& info)
{
    line("scene", info["path"].get<std::string>());
    if (info.contains("volume")) {
        line("volume", info["volume"]["path"].get<std::string>());
        if (const auto files = info["volume"]["files"].get<std::size_t>(); files > 1)
            line("files", fmt::format("{}, a time series; this is the first", files));
        print_geometry(info["volume"]);
        line("memory", format_bytes(info["memory_bytes_needed"].get<std::uint64_t>()) + " to render it");
    }
    fmt::print("{}\n", info["scene"].dump(2));
}

} // namespace lumisweep::cli
