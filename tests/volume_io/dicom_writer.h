// Minimal DICOM files: explicit little-endian value representations, one group after the other.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "volume_io/test_files.h"

namespace lumisweep::test {

inline std::string le16(unsigned v) { return {char(v & 255), char(v >> 8 & 255)}; }
inline std::string le32(std::uint64_t v) { return le16(unsigned(v & 0xffff)) + le16(unsigned(v >> 16 & 0xffff)); }

inline std::string element(unsigned group, unsigned tag, const std::string& vr, std::string value)
{
    if (value.size() % 2 == 1)
        value += vr == "UI" || vr == "OB" ? '\0' : ' ';
    const bool long_form = vr == "OB" || vr == "OW" || vr == "SQ";
    return le16(group) + le16(tag) + vr + (long_form ? le16(0) + le32(value.size()) : le16(unsigned(value.size()))) +
           value;
}

inline std::string item(const std::string& content)
{
    return le16(0xfffe) + le16(0xe000) + le32(content.size()) + content;
}

/// One file of a series; the defaults are a CT slice at the origin.
struct DicomFile {
    std::string sop_class = "1.2.840.10008.5.1.4.1.1.2", modality = "CT", series = "1.2.3.4", instance = "1";
    std::string sop_instance = "1.2.3.4.1";
    std::string orientation = "1\\0\\0\\0\\1\\0", spacing = "1\\1", thickness, between;
    std::optional<std::string> position = "0\\0\\0", slope, intercept;
    unsigned columns = 5, rows = 4, bits = 16, stored = 16, is_signed = 1, samples = 1;
    std::optional<unsigned> padding;
    std::string pixels;
    std::string frames;            ///< number of frames; empty in classic files
    std::string functional_groups; ///< elements of group 5200

    std::string bytes() const
    {
        std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) + element(2, 2, "UI", sop_class) +
                           element(2, 3, "UI", sop_instance) + element(2, 0x10, "UI", "1.2.840.10008.1.2.1") +
                           element(2, 0x12, "UI", "1.2.3");
        meta = element(2, 0, "UL", le32(meta.size())) + meta;
        std::string d =
            element(8, 0x16, "UI", sop_class) + element(8, 0x18, "UI", sop_instance) + element(8, 0x60, "CS", modality);
        if (!thickness.empty())
            d += element(0x18, 0x50, "DS", thickness);
        if (!between.empty())
            d += element(0x18, 0x88, "DS", between);
        d += element(0x20, 0xd, "UI", "1.2.3") + element(0x20, 0xe, "UI", series) + element(0x20, 0x13, "IS", instance);
        if (position)
            d += element(0x20, 0x32, "DS", *position);
        if (!orientation.empty())
            d += element(0x20, 0x37, "DS", orientation);
        d += element(0x28, 2, "US", le16(samples)) + element(0x28, 4, "CS", samples == 1 ? "MONOCHROME2" : "RGB");
        if (samples > 1)
            d += element(0x28, 6, "US", le16(0));
        if (!frames.empty())
            d += element(0x28, 8, "IS", frames);
        d += element(0x28, 0x10, "US", le16(rows)) + element(0x28, 0x11, "US", le16(columns));
        if (!spacing.empty())
            d += element(0x28, 0x30, "DS", spacing);
        d += element(0x28, 0x100, "US", le16(bits)) + element(0x28, 0x101, "US", le16(stored)) +
             element(0x28, 0x102, "US", le16(stored - 1)) + element(0x28, 0x103, "US", le16(is_signed));
        if (padding)
            d += element(0x28, 0x120, "US", le16(*padding));
        if (intercept)
            d += element(0x28, 0x1052, "DS", *intercept);
        if (slope)
            d += element(0x28, 0x1053, "DS", *slope);
        d += functional_groups;
        d += element(0x7fe0, 0x10, bits == 8 ? "OB" : "OW", pixels);
        return std::string(128, '\0') + "DICM" + meta + d;
    }
};

/// Slice k of the ramp, at z.
inline DicomFile ct_slice(int k, double z)
{
    DicomFile f;
    f.instance = std::to_string(k + 1);
    f.sop_instance = "1.2.3.4." + std::to_string(k + 1);
    f.position = "0\\0\\" + std::to_string(z);
    std::vector<std::int16_t> v = ramp<std::int16_t>(5, 4, 1);
    for (auto& x : v)
        x = static_cast<std::int16_t>(x + 100 * k);
    f.pixels = bytes_of(v);
    return f;
}

} // namespace lumisweep::test
