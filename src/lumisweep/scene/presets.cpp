#include "lumisweep/scene/presets.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lumisweep/base/error.h"

namespace lumisweep {

namespace {

constexpr std::array<std::string_view, 5> names{"ct-bone", "ct-soft-tissue", "ct-vessels-and-metal", "mr-default",
                                                "smoke"};

constexpr Vec3d ivory{0.94, 0.89, 0.78}, pale_ivory{0.97, 0.95, 0.90};
constexpr Vec3d skin{0.93, 0.72, 0.62}, muscle{0.90, 0.50, 0.44};
constexpr Vec3d blood{0.95, 0.30, 0.24}, metal{0.78, 0.83, 0.90};

/// Share of the finite voxels at or above a value.
double share_above(const ValueStatistics& values, double value)
{
    std::uint64_t above = 0;
    for (std::size_t b = 0; b < values.histogram.size(); ++b)
        if (values.min + static_cast<double>(b) * values.bin_width >= value)
            above += values.histogram[b];
    return values.count == 0 ? 0.0 : static_cast<double>(above) / static_cast<double>(values.count);
}

// Bone stops light within about a millimetre, cartilage and contrast medium shine through.
std::vector<TransferPoint> ct_bone()
{
    return {{150, 0.0, {0.90, 0.72, 0.60}}, {280, 0.7, ivory}, {500, 4.0, ivory}, {1500, 8.0, pale_ivory}};
}

// A translucent skin of a few millimetres' depth over red muscle and solid bone.
std::vector<TransferPoint> ct_soft_tissue()
{
    return {{-400, 0.0, skin},  {-150, 0.22, skin}, {-20, 0.30, skin}, {40, 0.35, muscle},
            {130, 0.6, muscle}, {280, 1.5, ivory},  {500, 4.0, ivory}, {1500, 8.0, pale_ivory}};
}

// Contrast medium in red, bone in ivory, and everything denser than bone as bright metal.
std::vector<TransferPoint> ct_vessels_and_metal()
{
    return {{130, 0.0, blood}, {220, 0.6, blood},  {450, 1.5, {0.95, 0.50, 0.38}},
            {700, 3.0, ivory}, {1000, 8.0, metal}, {1600, 20.0, metal}};
}

// MR has no units: values relative to the bright end of the tissue, lengths relative to a head of 200 mm.
std::vector<TransferPoint> mr_default(const PresetInput& input)
{
    const ValueStatistics& values = input.values;
    const double low = values.min;
    const double top = values.percentile_above(values.background_threshold(), 0.99);
    const double range = top > low ? top - low : 1.0;
    const double per_length = 200.0 / input.diameter;
    const auto at = [&](double fraction) { return low + fraction * range; };
    return {{at(0.18), 0.0, skin},
            {at(0.30), 0.5 * per_length, skin},
            {at(0.55), 1.2 * per_length, {0.88, 0.66, 0.60}},
            {at(0.80), 2.0 * per_length, {0.93, 0.84, 0.78}},
            {at(1.00), 3.0 * per_length, {0.97, 0.93, 0.88}}};
}

// Optical depth 30 across the whole box at full density: billows a tenth of it thick are half opaque at a third of
// that.
std::vector<TransferPoint> smoke(const PresetInput& input)
{
    const ValueStatistics& values = input.values;
    double low = values.min < 0.0 ? values.min : 0.0;
    // 8-bit frames of a series share one scale; otherwise the densest of this frame sets it.
    double top = values.integers && values.bits == 8 && values.min >= 0.0
                     ? std::max(255.0 * values.bin_width, values.max)
                     : values.percentile_above(values.min + values.bin_width, 0.995);
    if (values.min > 0.0 && values.min > 0.5 * values.max && values.max > values.min) // not empty anywhere: subtract it
        low = values.min;
    if (!(top > low))
        top = low + 1.0;
    const Vec3d white{0.96, 0.96, 0.97};
    const double full = 60.0 / input.diameter;
    return {{low + 0.01 * (top - low), 0.0, white}, {low + 0.3 * (top - low), 0.2 * full, white}, {top, full, white}};
}

PresetChoice ct_choice(const ValueStatistics& values, const std::string& because)
{
    const double offset = hounsfield_offset(values);
    const double dense = share_above(values, 300.0 + offset);
    const double metallic = share_above(values, 1000.0 + offset);
    const bool vessels = metallic > 1e-4 && dense < 0.03 && metallic < 0.2 * dense;
    const char* name = vessels ? "ct-vessels-and-metal" : dense < 0.002 ? "ct-soft-tissue" : "ct-bone";
    const char* detail = vessels         ? " and few voxels are dense, some of them like metal"
                         : dense < 0.002 ? " and hardly a voxel is as dense as bone"
                                         : "";
    return {name, fmt::format("no preset named: took {} because {}{}", name, because, detail)};
}

PresetChoice plain_choice(const char* name, const char* because)
{
    return {name, fmt::format("no preset named: took {} because {}", name, because)};
}

} // namespace

PresetInput preset_input(const ScalarGrid& volume, ValueStatistics values, const std::string& modality, int frames)
{
    const Vec3i size = volume.size();
    PresetInput input;
    input.modality = modality;
    input.values = std::move(values);
    input.frames = frames;
    input.diameter = std::cbrt(std::abs(determinant(volume.world_from_voxel())) * size.x * size.y * size.z);
    return input;
}

std::span<const std::string_view> preset_names() { return names; }

double hounsfield_offset(const ValueStatistics& values)
{
    // Air is −1000 HU and water 0: stored with +1024, nothing is negative, the air lies far below 300, and what is left
    // above that (the body) has its middle near 1024.
    if (values.count == 0 || values.min < 0.0 || values.max < 1200.0)
        return 0.0;
    const double body = values.percentile_above(std::max(300.0, values.min), 0.5);
    return body > 850.0 && body < 1400.0 && share_above(values, 300.0) > 0.1 ? 1024.0 : 0.0;
}

PresetChoice choose_preset(const PresetInput& input)
{
    const ValueStatistics& values = input.values;
    const bool wide_integers = values.integers && values.bits >= 16;
    if (input.modality == "CT")
        return ct_choice(values, "the modality is CT");
    if (input.modality == "XA" || input.modality == "RF")
        return plain_choice("ct-vessels-and-metal", "the modality is an angiography's");
    if (!input.modality.empty())
        return {"mr-default",
                fmt::format("no preset named: took mr-default because the modality is {}", input.modality)};
    if (input.frames > 1)
        return plain_choice("smoke", "the file is a time series");
    if (values.min <= -500.0 && values.min >= -4096.0 && values.max >= 300.0)
        return ct_choice(values, fmt::format("values from {:g} to {:g} are Hounsfield units", values.min, values.max));
    if (hounsfield_offset(values) != 0.0)
        return ct_choice(values, "the histogram is that of Hounsfield units + 1024");
    if (wide_integers && values.min >= 0.0 && values.max >= 1000.0 && values.max <= 4095.0 &&
        values.lowest_share() > 0.3)
        return ct_choice(
            values, fmt::format("16-bit values from {:g} to {:g}, most of them the lowest, look like a cropped CT's",
                                values.min, values.max));
    if (values.lowest_share() > 0.8 || (!values.integers && values.min >= 0.0 && values.max <= 16.0))
        return plain_choice("smoke", values.lowest_share() > 0.8 ? "most voxels are empty"
                                                                 : "small floating-point values look like a density");
    return plain_choice("mr-default", "neither modality nor histogram say more");
}

std::vector<TransferPoint> preset_points(std::string_view name, const PresetInput& input)
{
    if (name == "mr-default")
        return mr_default(input);
    if (name == "smoke")
        return smoke(input);
    std::vector<TransferPoint> points;
    if (name == "ct-bone")
        points = ct_bone();
    else if (name == "ct-soft-tissue")
        points = ct_soft_tissue();
    else if (name == "ct-vessels-and-metal")
        points = ct_vessels_and_metal();
    else
        fail("transfer_function.preset: \"{}\" is not known (give one of {})", name, fmt::join(names, ", "));
    const double offset = hounsfield_offset(input.values);
    for (TransferPoint& point : points)
        point.value += offset;
    return points;
}

} // namespace lumisweep
