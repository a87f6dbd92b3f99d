// DICOM: a directory with a series, or one file. DCMTK reads headers and decodes pixels.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "lumisweep/base/error.h"
#include "lumisweep/volume/io/dicom_file.h"
#include "lumisweep/volume/io/dicom_slices.h"
#include "lumisweep/volume/io/formats.h"
#include "lumisweep/volume/io/geometry.h"

namespace lumisweep {

namespace {

template <class T>
void to_values(const std::byte* stored, double slope, double intercept, std::span<float> values)
{
    for (std::size_t i = 0; i < values.size(); ++i) {
        T raw;
        std::memcpy(&raw, stored + i * sizeof(T), sizeof(T));
        values[i] = static_cast<float>(slope * static_cast<double>(raw) + intercept);
    }
}

/// Padding above all real values would stand around the patient like a wall: it becomes the slice's lowest value. Other
/// padding stays, because 0 is often declared as such although water or noise is stored as 0, too.
template <class T>
void lower_padding(std::vector<std::byte>& pixels, T padding)
{
    T lowest = padding;
    for (std::size_t i = 0; i < pixels.size(); i += sizeof(T)) {
        T v;
        std::memcpy(&v, pixels.data() + i, sizeof(T));
        if (v > padding)
            return;
        lowest = std::min(lowest, v);
    }
    for (std::size_t i = 0; i < pixels.size() && lowest < padding; i += sizeof(T)) {
        T v;
        std::memcpy(&v, pixels.data() + i, sizeof(T));
        if (v == padding)
            std::memcpy(pixels.data() + i, &lowest, sizeof(T));
    }
}

template <class Function>
void visit_type(StoredType type, Function&& f)
{
    switch (type) {
    case StoredType::i8: return f(std::int8_t{});
    case StoredType::u8: return f(std::uint8_t{});
    case StoredType::i16: return f(std::int16_t{});
    case StoredType::u16: return f(std::uint16_t{});
    case StoredType::i32: return f(std::int32_t{});
    case StoredType::u32: return f(std::uint32_t{});
    case StoredType::i64: return f(std::int64_t{});
    case StoredType::u64: return f(std::uint64_t{});
    case StoredType::f32: return f(float{});
    case StoredType::f64: return f(double{});
    }
}

/// Planes of a stack, decoded and blended one after the other.
class StackVoxels : public VoxelSource {
public:
    /// Where slices differ in type or scale (`type` is f32 then, theirs not), planes hold values instead of raw voxels.
    StackVoxels(SliceStack stack, std::uint64_t pixels, StoredType type, bool raw)
        : stack_(std::move(stack)), pixels_(std::size_t(pixels)), type_(type), raw_(raw)
    {
    }

    void rewind() override
    {
        next_plane_ = 0;
        position_ = plane_.size();
    }

    void read(std::span<std::byte> bytes) override
    {
        while (!bytes.empty()) {
            if (position_ == plane_.size())
                make_plane();
            const std::size_t n = std::min(bytes.size(), plane_.size() - position_);
            std::memcpy(bytes.data(), plane_.data() + position_, n);
            position_ += n;
            bytes = bytes.subspan(n);
        }
    }

private:
    struct Cached {
        std::size_t slice = static_cast<std::size_t>(-1);
        std::vector<std::byte> voxels;
    };

    void make_plane()
    {
        const SliceBlend blend = stack_.planes.at(next_plane_++);
        plane_ = slice(blend.below);
        position_ = 0;
        if (blend.weight <= 0.0)
            return;
        const std::vector<std::byte>& above = slice(blend.above);
        visit_type(type_, [&](auto tag) {
            using T = decltype(tag);
            for (std::size_t i = 0; i < pixels_; ++i) {
                T a, b;
                std::memcpy(&a, plane_.data() + i * sizeof(T), sizeof(T));
                std::memcpy(&b, above.data() + i * sizeof(T), sizeof(T));
                const double mixed = double(a) + blend.weight * (double(b) - double(a));
                const T v = std::is_integral_v<T> ? static_cast<T>(std::nearbyint(mixed)) : static_cast<T>(mixed);
                std::memcpy(plane_.data() + i * sizeof(T), &v, sizeof(T));
            }
        });
    }

    const std::vector<std::byte>& slice(std::size_t index)
    {
        // Planes come in order, so the two latest slices are all that is needed again.
        for (const Cached& c : cache_)
            if (c.slice == index)
                return c.voxels;
        Cached& c = cache_[oldest_];
        oldest_ = 1 - oldest_;
        c.slice = static_cast<std::size_t>(-1);
        c.voxels = decode(stack_.slices.at(index));
        c.slice = index;
        return c.voxels;
    }

    std::vector<std::byte> decode(const DicomSlice& s)
    {
        const std::string where = s.file.string();
        if (decoded_file_ != s.file) {
            decoded_file_.clear();
            decoded_ = decode_dicom_pixels(s.file);
            decoded_file_ = s.file;
        }
        const std::size_t bytes = pixels_ * size_of(s.type);
        require((s.frame + 1) * bytes <= decoded_.size(),
                "{}: holds {} bytes of pixels where its header promises {} (the file is truncated; copy it again)",
                where, decoded_.size(), (s.frame + 1) * bytes);
        const std::byte* first = decoded_.data() + s.frame * bytes;
        std::vector<std::byte> pixels(first, first + bytes);
        if (s.padding)
            visit_type(s.type, [&](auto tag) { lower_padding(pixels, static_cast<decltype(tag)>(*s.padding)); });
        if (raw_)
            return pixels;
        std::vector<std::byte> values(pixels_ * sizeof(float));
        visit_type(s.type, [&](auto tag) {
            to_values<decltype(tag)>(pixels.data(), s.slope, s.intercept,
                                     {reinterpret_cast<float*>(values.data()), pixels_});
        });
        return values;
    }

    SliceStack stack_;
    std::size_t pixels_;
    StoredType type_;
    bool raw_;
    std::array<Cached, 2> cache_;
    std::size_t oldest_ = 0;
    std::filesystem::path decoded_file_;
    std::vector<std::byte> decoded_;
    std::vector<std::byte> plane_;
    std::size_t position_ = 0, next_plane_ = 0;
};

} // namespace

OpenedVolume open_dicom(const std::filesystem::path& path)
{
    const std::string where = path.string();
    const DicomSeries series = find_dicom_series(path);

    OpenedVolume opened;
    VolumeHeader& header = opened.header;
    header.format = "DICOM";
    header.modality = series.modality;
    header.warnings = series.warnings;
    const SliceStack stack = stack_slices(series, where, header.warnings);
    header.size = checked_size({series.columns, series.rows, stack.planes.size()}, where);
    header.world_from_voxel = place_grid(
        {series.row_direction * series.column_spacing, series.column_direction * series.row_spacing, stack.step},
        stack.origin, where);

    const DicomSlice& first = stack.slices.front();
    bool raw = true;
    for (const DicomSlice& s : stack.slices)
        raw = raw && s.type == first.type && s.slope == first.slope && s.intercept == first.intercept;
    opened.type = raw ? first.type : StoredType::f32;
    if (raw) {
        header.slope = first.slope;
        header.intercept = first.intercept;
    } else {
        header.warnings.push_back(
            fmt::format("{}: slices differ in pixel type or rescale slope; voxels are stored as floats", where));
    }
    const std::uint64_t pixels = series.columns * series.rows;
    std::uint64_t frames_in_file = 1;
    for (const DicomSlice& s : stack.slices)
        frames_in_file = std::max(frames_in_file, s.frame + 1);
    // DCMTK holds the file and its decoded copy; then a slice's stored pixels, two cached slices and the plane.
    opened.working_bytes = pixels * ((2 * frames_in_file + 1) * size_of(first.type) + 3 * size_of(opened.type));
    opened.voxels = [stack, pixels, type = opened.type, raw](int) -> std::unique_ptr<VoxelSource> {
        return std::make_unique<StackVoxels>(stack, pixels, type, raw);
    };
    return opened;
}

} // namespace lumisweep
