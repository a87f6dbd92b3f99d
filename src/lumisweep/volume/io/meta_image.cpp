// MetaImage (.mha, .mhd). Read here and not through MetaIO, which copies header fields into fixed arrays without
// checking their length and leaves the rest of a truncated compressed volume uninitialised.
#include <array>
#include <bit>
#include <cmath>
#include <map>

#include "lumisweep/base/error.h"
#include "lumisweep/volume/io/formats.h"
#include "lumisweep/volume/io/geometry.h"
#include "lumisweep/volume/io/meta_header.h"

namespace lumisweep {

namespace fs = std::filesystem;

namespace {

StoredType stored_type(const MetaHeader& meta)
{
    // MetaIO's "long" has four bytes on every platform.
    static const std::map<std::string, StoredType> types{
        {"MET_CHAR", StoredType::i8},        {"MET_UCHAR", StoredType::u8},  {"MET_SHORT", StoredType::i16},
        {"MET_USHORT", StoredType::u16},     {"MET_INT", StoredType::i32},   {"MET_UINT", StoredType::u32},
        {"MET_LONG", StoredType::i32},       {"MET_ULONG", StoredType::u32}, {"MET_LONG_LONG", StoredType::i64},
        {"MET_ULONG_LONG", StoredType::u64}, {"MET_FLOAT", StoredType::f32}, {"MET_DOUBLE", StoredType::f64}};
    const auto found = types.find(meta.text("ElementType"));
    require(found != types.end(),
            "{}: ElementType is missing or no scalar type (store MET_SHORT, MET_FLOAT or the like)", meta.where());
    return found->second;
}

/// The first key of several spellings that is there.
std::vector<double> first_of(const MetaHeader& meta, std::initializer_list<const char*> keys, std::size_t count)
{
    for (const char* key : keys)
        if (auto list = meta.numbers(key, count); !list.empty())
            return list;
    return {};
}

void read_geometry(const MetaHeader& meta, std::size_t dimension, VolumeHeader& header)
{
    auto spacing = first_of(meta, {"ElementSpacing", "ElementSize"}, dimension);
    if (spacing.empty()) {
        spacing.assign(dimension, 1.0);
        header.warnings.push_back(fmt::format("{}: no ElementSpacing, 1 mm is assumed", meta.where()));
    }
    const auto offset = first_of(meta, {"Offset", "Origin", "Position"}, dimension);
    // Row i of the matrix as written is the direction of axis i.
    const auto matrix = first_of(meta, {"TransformMatrix", "Rotation", "Orientation"}, dimension * dimension);
    std::array<Vec3d, 3> step{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Vec3d origin{0, 0, 0};
    const std::size_t spatial = std::min<std::size_t>(dimension, 3);
    for (std::size_t i = 0; i < spatial; ++i) {
        for (std::size_t c = 0; c < spatial && !matrix.empty(); ++c)
            component(step[i], int(c)) = matrix[i * dimension + c];
        step[i] = step[i] * spacing[i]; // a negative one makes the axis run backwards
        if (!offset.empty())
            component(origin, int(i)) = offset[i];
    }
    header.world_from_voxel = place_grid(step, origin, meta.where());
}

void read_scale(const MetaHeader& meta, VolumeHeader& header)
{
    if (const auto slope = meta.numbers("ElementToIntensityFunctionSlope", 1); !slope.empty())
        header.slope = slope[0];
    if (const auto offset = meta.numbers("ElementToIntensityFunctionOffset", 1); !offset.empty())
        header.intercept = offset[0];
    require(
        std::isfinite(header.slope) && header.slope != 0.0 && std::isfinite(header.intercept),
        "{}: ElementToIntensityFunction slope {} and offset {} must be finite and the slope not 0 (mend the header)",
        meta.where(), header.slope, header.intercept);
}

std::uint64_t side(double size, const MetaHeader& meta)
{
    require(size >= 1.0 && size <= 2147483647.0 && size == std::floor(size),
            "{}: DimSize {} must be a positive whole number (mend the header)", meta.where(), size);
    return static_cast<std::uint64_t>(size);
}

} // namespace

OpenedVolume open_meta_image(const fs::path& path)
{
    const MetaHeader meta(path);
    const std::string& where = meta.where();
    OpenedVolume opened;
    VolumeHeader& header = opened.header;
    header.format = "MetaImage";
    opened.type = stored_type(meta);

    const std::int64_t dimension = meta.integer("NDims", 0);
    require(dimension >= 2 && dimension <= 4, "{}: NDims = {}; 2 to 4 can be read (mend the header)", where, dimension);
    const auto sides = meta.numbers("DimSize", std::size_t(dimension));
    require(!sides.empty(), "{}: DimSize is missing (mend the header)", where);
    header.size =
        checked_size({side(sides[0], meta), side(sides[1], meta), dimension > 2 ? side(sides[2], meta) : 1}, where);
    header.frames = checked_frames(dimension > 3 ? side(sides[3], meta) : 1, where);
    const std::int64_t channels = meta.integer("ElementNumberOfChannels", 1);
    require(channels == 1, "{}: {} channels per voxel; only scalar volumes can be shown (store one channel)", where,
            channels);
    require(meta.text("BinaryData").empty() || meta.flag("BinaryData"),
            "{}: voxels are written as text (store them as binary)", where);
    read_geometry(meta, std::size_t(dimension), header);
    read_scale(meta, header);
    if (const std::string modality = meta.text("Modality"); modality == "MET_MOD_CT" || modality == "MET_MOD_MR")
        header.modality = modality.substr(8);

    FrameLayout layout;
    layout.inner_bytes = size_of(opened.type) * std::uint64_t(header.size.x) * std::uint64_t(header.size.y) *
                         std::uint64_t(header.size.z);
    layout.frames = std::uint64_t(header.frames);

    const bool big = meta.flag("BinaryDataByteOrderMSB") || meta.flag("ElementByteOrderMSB");
    opened.order = big == (std::endian::native == std::endian::big) ? ByteOrder::native : ByteOrder::swapped;
    const Compression compression = meta.flag("CompressedData") ? Compression::deflate : Compression::none;
    const std::string name = meta.text("ElementDataFile");
    const bool local = name == "LOCAL" || name == "Local" || name == "local";
    require(!name.empty() && name.compare(0, 4, "LIST") != 0 && name.find('%') == std::string::npos,
            "{}: ElementDataFile names several files (store the voxels in one file)", where);
    const fs::path file = local ? path : path.parent_path() / name;
    std::uint64_t offset = local ? meta.bytes() : 0;
    const std::int64_t skip = meta.integer("HeaderSize", 0);
    require_plausible_size(file, offset, compression, layout.total_bytes());
    if (skip == -1 && compression == Compression::none)
        offset = fs::file_size(file) - layout.total_bytes(); // the voxels are the file's end
    else {
        require(skip >= 0, "{}: HeaderSize = {} (mend the header)", where, skip);
        offset += std::uint64_t(skip);
        require_plausible_size(file, offset, compression, layout.total_bytes());
    }

    opened.voxels = [file, offset, compression, layout](int frame) -> std::unique_ptr<VoxelSource> {
        return std::make_unique<FileVoxels>(std::make_unique<ByteSource>(file, offset, compression), 0, layout, frame);
    };
    return opened;
}

} // namespace lumisweep
