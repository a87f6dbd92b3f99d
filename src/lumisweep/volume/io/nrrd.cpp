// NRRD with attached or detached header. Header and unusual encodings (ascii, hex, several data files, skipped lines)
// go through NrrdIO; raw and gzip data are read here, so that one frame does not cost the memory of all.
#include <array>
#include <cstdlib>
#include <fstream>
#include <mutex>

#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/volume/io/formats.h"
#include "lumisweep/volume/io/geometry.h"
#include "lumisweep/volume/io/nrrd_file.h"

namespace lumisweep {

namespace fs = std::filesystem;

namespace {

/// NrrdIO collects its messages in a process-wide list.
std::mutex nrrd_mutex;

/// The innermost cause: the last line of "[nrrd] function: message" lines.
std::string take_nrrd_error()
{
    const std::unique_ptr<char, decltype(&std::free)> text(biffGetDone(nrrdBiffKey), &std::free);
    std::string cause = text ? text.get() : "unknown error";
    while (!cause.empty() && cause.back() == '\n')
        cause.pop_back();
    cause.erase(0, cause.rfind('\n') + 1);
    const auto colon = cause.find(": ");
    if (colon != std::string::npos && cause.compare(0, 1, "[") == 0)
        cause.erase(0, colon + 2);
    for (char& c : cause)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e)
            c = '?';
    return cause;
}

StoredType stored_type(const Nrrd& nrrd, const std::string& where)
{
    switch (nrrd.type) {
    case nrrdTypeChar: return StoredType::i8;
    case nrrdTypeUChar: return StoredType::u8;
    case nrrdTypeShort: return StoredType::i16;
    case nrrdTypeUShort: return StoredType::u16;
    case nrrdTypeInt: return StoredType::i32;
    case nrrdTypeUInt: return StoredType::u32;
    case nrrdTypeLLong: return StoredType::i64;
    case nrrdTypeULLong: return StoredType::u64;
    case nrrdTypeFloat: return StoredType::f32;
    case nrrdTypeDouble: return StoredType::f64;
    default: fail("{}: voxels are not numbers (store one integer or float per voxel)", where);
    }
}

/// Where plain raw or gzip data start, or nothing when NrrdIO has to read them.
struct PlainData {
    fs::path file;
    std::uint64_t offset = 0;
    Compression compression = Compression::none;
    bool ok = false;
};

/// An attached header ends with its first empty line.
std::uint64_t header_bytes(const fs::path& path)
{
    std::ifstream in(path, std::ios::binary);
    for (std::string line; std::getline(in, line);)
        if (line.empty() || line == "\r")
            return static_cast<std::uint64_t>(std::max<std::streamoff>(in.tellg(), 0));
    fail("{}: no empty line after the header (the file is truncated; copy or export it again)", path.string());
}

PlainData find_plain_data(const fs::path& path, const NrrdIoState& io)
{
    PlainData data;
    const bool gzip = io.encoding == nrrdEncodingGzip;
    if ((io.encoding != nrrdEncodingRaw && !gzip) || io.lineSkip != 0 || io.byteSkip != 0 || io.dataFNFormat ||
        io.dataFNArr->len > 1)
        return data;
    data.compression = gzip ? Compression::deflate : Compression::none;
    if (io.dataFNArr->len == 1) {
        data.file = path.parent_path() / io.dataFN[0]; // an absolute name replaces the folder
    } else {
        data.file = path;
        data.offset = header_bytes(path);
    }
    data.ok = true;
    return data;
}

std::unique_ptr<VoxelSource> load_all(const fs::path& path, const FrameLayout& layout, int frame)
{
    require_memory(layout.total_bytes(), path.string(), "store the file with raw or gzip encoding in one piece");
    const std::shared_ptr<Nrrd> nrrd = NrrdPtr(nrrdNew());
    const NrrdIoPtr io(nrrdIoStateNew());
    load_nrrd(*nrrd, *io, path, NrrdPart::all);
    require(nrrd->data && nrrdElementNumber(nrrd.get()) * nrrdElementSize(nrrd.get()) >= layout.total_bytes(),
            "{}: the file changed while it was read (try again)", path.string());
    return std::make_unique<MemoryVoxels>(nrrd, static_cast<const std::byte*>(nrrd->data), layout, frame);
}

} // namespace

void load_nrrd(Nrrd& nrrd, NrrdIoState& io, const fs::path& path, NrrdPart part)
{
    const std::lock_guard lock(nrrd_mutex);
    nrrdIoStateSet(&io, nrrdIoStateSkipData, part == NrrdPart::header ? 1 : 0);
    if (nrrdLoad(&nrrd, path.c_str(), &io) != 0)
        fail("{}: not a readable NRRD file, {} (mend the header, or copy or export the file again)", path.string(),
             take_nrrd_error());
}

OpenedVolume open_nrrd(const fs::path& path)
{
    const std::string where = path.string();
    const NrrdPtr nrrd(nrrdNew());
    const NrrdIoPtr io(nrrdIoStateNew());
    load_nrrd(*nrrd, *io, path, NrrdPart::header);

    OpenedVolume opened;
    opened.header.format = "NRRD";
    opened.type = stored_type(*nrrd, where);
    const FrameLayout layout = interpret_nrrd_axes(*nrrd, opened.header, where);
    if (const PlainData data = find_plain_data(path, *io); data.ok) {
        require_plausible_size(data.file, data.offset, data.compression, layout.total_bytes());
        opened.order =
            io->endian == airEndianUnknown || io->endian == airMyEndian() ? ByteOrder::native : ByteOrder::swapped;
        opened.voxels = [data, layout](int frame) -> std::unique_ptr<VoxelSource> {
            auto bytes = std::make_unique<ByteSource>(data.file, data.offset, data.compression);
            return std::make_unique<FileVoxels>(std::move(bytes), 0, layout, frame);
        };
    } else {
        opened.working_bytes = layout.total_bytes(); // NrrdIO reads everything, in native byte order
        opened.voxels = [path, layout](int frame) { return load_all(path, layout, frame); };
    }
    return opened;
}

} // namespace lumisweep
