#include "lumisweep/image/exr_header.h"

#include <algorithm>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTileDescription.h>
#include <OpenEXR/ImfVersion.h>
#include <OpenEXR/ImfXdr.h>

#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/image/exr_detail.h"

namespace lumisweep::exr_detail {
namespace {

constexpr int max_parts = 256;
constexpr std::uint64_t max_channels = 4096;

struct Size {
    std::uint64_t width, height;
};

Size window_size(const Imath::Box2i& window, const char* kind, const std::string& name)
{
    const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
    const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
    require(width >= 1 && height >= 1 && width <= max_size && height <= max_size,
            "{}: not a usable OpenEXR file: its {} window has {} x {} pixels (1 to {} each way can be read)", name,
            kind, width, height, max_size);
    return {static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height)};
}

std::uint64_t rows_in_chunk(Imf::Compression compression)
{
    switch (compression) {
    case Imf::ZIP_COMPRESSION:
    case Imf::PXR24_COMPRESSION: return 16;
    case Imf::PIZ_COMPRESSION:
    case Imf::B44_COMPRESSION:
    case Imf::B44A_COMPRESSION:
    case Imf::DWAA_COMPRESSION: return 32;
    case Imf::DWAB_COMPRESSION: return 256;
    default: return 1;
    }
}

std::uint64_t count_channels(const Imf::Header& header)
{
    std::uint64_t count = 0;
    for (auto it = header.channels().begin(); it != header.channels().end(); ++it)
        ++count;
    return count;
}

void check_header(const Imf::Header& header, bool is_first, std::uint64_t file_bytes, const std::string& name)
{
    const Size data = window_size(header.dataWindow(), "data", name);
    const Size display = window_size(header.displayWindow(), "display", name);
    const std::uint64_t channels = count_channels(header);
    require(channels >= 1 && channels <= max_channels, "{}: {} channels (1 to {} can be read)", name, channels,
            max_channels);

    std::uint64_t chunks = 0, chunk_pixels = 0;
    if (header.hasTileDescription()) {
        const Imf::TileDescription& tiles = header.tileDescription();
        require(tiles.xSize >= 1 && tiles.ySize >= 1 && tiles.xSize <= max_size && tiles.ySize <= max_size,
                "{}: not a usable OpenEXR file: tiles of {} x {} pixels (save it again)", name, tiles.xSize,
                tiles.ySize);
        const auto divided_up = [](std::uint64_t a, std::uint64_t b) { return (a + b - 1) / b; };
        chunks = divided_up(data.width, tiles.xSize) * divided_up(data.height, tiles.ySize);
        chunk_pixels = std::uint64_t{tiles.xSize} * tiles.ySize;
    } else {
        const std::uint64_t rows = rows_in_chunk(header.compression());
        chunks = (data.height + rows - 1) / rows;
        chunk_pixels = rows * data.width;
    }
    // Each chunk needs eight bytes in the directory at least: a short file cannot claim many pixels.
    require(chunks <= file_bytes / 8, "{}: {} x {} pixels in {} bytes: the file is truncated or broken (get it again)",
            name, data.width, data.height, file_bytes);
    if (!is_first)
        return;
    const std::uint64_t values = data.width * data.height + display.width * display.height;
    const std::uint64_t buffers = 2 * static_cast<std::uint64_t>(std::max(threads(), 1)) + 1;
    require_memory(4 * channels * (values + std::min(buffers, chunks) * chunk_pixels),
                   fmt::format("{} with {} x {} pixels and {} channels", name, data.width, data.height, channels),
                   "use a smaller image");
}

/// A name ended by a zero byte; empty at the end of a header.
std::string read_name(Imf::IStream& stream, const std::string& name)
{
    std::string text;
    for (char c = 1; text.size() < 256;) {
        Imf::Xdr::read<Imf::StreamIO>(stream, c);
        if (c == '\0')
            return text;
        text.push_back(c);
    }
    fail("{}: a name in its header does not end: not a sound OpenEXR file (get it again)", name);
}

/// The library takes the memory that an attribute claims before it reads it: two gigabytes from a file of a hundred
/// bytes. Leaves the stream where it was.
void check_attribute_sizes(Imf::IStream& stream, std::uint64_t file_bytes, const std::string& name)
{
    const std::uint64_t begin = stream.tellg();
    for (std::string key = read_name(stream, name); !key.empty(); key = read_name(stream, name)) {
        read_name(stream, name); // its type
        int size = 0;
        Imf::Xdr::read<Imf::StreamIO>(stream, size);
        const std::uint64_t position = stream.tellg();
        require(size >= 0 && position <= file_bytes && static_cast<std::uint64_t>(size) <= file_bytes - position,
                "{}: attribute '{}' claims {} bytes: the file is truncated or broken (get it again)", name,
                one_line(key.c_str()), size);
        stream.seekg(position + static_cast<std::uint64_t>(size));
    }
    stream.seekg(begin);
}

} // namespace

void check_headers(Imf::IStream& stream, std::uint64_t file_bytes, const std::string& name)
{
    int magic = 0, version = 0;
    require(file_bytes >= 8, "{}: not an OpenEXR file: it has {} bytes (give an .exr image)", name, file_bytes);
    Imf::Xdr::read<Imf::StreamIO>(stream, magic);
    require(magic == Imf::MAGIC, "{}: not an OpenEXR file (its first bytes say otherwise)", name);
    Imf::Xdr::read<Imf::StreamIO>(stream, version);
    require(Imf::getVersion(version) == Imf::EXR_VERSION && Imf::supportsFlags(Imf::getFlags(version)),
            "{}: OpenEXR version {} with flags {:#x} is unknown (save it again as version 2)", name,
            Imf::getVersion(version), Imf::getFlags(version));
    for (int part = 0; part < max_parts; ++part) {
        check_attribute_sizes(stream, file_bytes, name);
        Imf::Header header;
        header.readFrom(stream, version);
        if (header.readsNothing()) {
            require(part > 0, "{}: an OpenEXR file without any image (get it again)", name);
            return;
        }
        const bool is_deep = Imf::isNonImage(version) && (!header.hasType() || Imf::isDeepData(header.type()));
        require(part > 0 || !is_deep, "{}: deep OpenEXR images cannot be read (flatten it)", name);
        check_header(header, part == 0, file_bytes, name);
        if (!Imf::isMultiPart(version))
            return;
    }
    fail("{}: more than {} parts (save the first one by itself)", name, max_parts);
}

} // namespace lumisweep::exr_detail
