#include "lumisweep/scene/checkpoint.h"

#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <string_view>

#include <fcntl.h>
#include <unistd.h>

#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/scene/hash.h"
#include "lumisweep/scene/json_reader.h"
#include "lumisweep/scene/json_text.h"

namespace lumisweep {

static_assert(std::endian::native == std::endian::little, "checkpoints are written in the machine's byte order");

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::string_view magic = "LUMICKPT";
constexpr std::uint32_t format_version = 2;
constexpr std::size_t preamble_bytes = 16;

/// A file descriptor that writes all or throws.
class OutputFile {
public:
    explicit OutputFile(const fs::path& path)
        : path_(path), descriptor_(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666))
    {
        check(descriptor_ >= 0);
    }
    ~OutputFile()
    {
        if (descriptor_ >= 0)
            ::close(descriptor_);
    }
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    void write(const void* data, std::size_t size)
    {
        hash_ = hash_bytes(data, size, hash_);
        const char* at = static_cast<const char*>(data);
        while (size > 0) {
            const ssize_t written = ::write(descriptor_, at, size);
            if (written < 0 && errno == EINTR)
                continue;
            check(written > 0);
            at += written;
            size -= static_cast<std::size_t>(written);
        }
    }
    std::uint64_t hash() const { return hash_; }
    void flush_to_disk() { check(::fsync(descriptor_) == 0); }

private:
    void check(bool ok) const
    {
        require(ok, "{}: cannot write the checkpoint: {} (check the folder and the space on the disk)", path_.string(),
                std::strerror(errno));
    }

    fs::path path_;
    int descriptor_;
    std::uint64_t hash_ = 0;
};

std::string header_text(const Film& film, const Fingerprint& fingerprint)
{
    ordered_json header;
    header["width"] = film.width();
    header["height"] = film.height();
    header["samples"] = film.samples();
    header["fingerprint"] = fingerprint;
    return header.dump();
}

class InputFile {
public:
    explicit InputFile(const fs::path& path) : path_(path), in_(path, std::ios::binary)
    {
        std::error_code ignored;
        require(fs::exists(path, ignored), "{}: no such checkpoint (check the path)", path.string());
        require(in_.good() && fs::is_regular_file(path, ignored), "{}: cannot be read as a checkpoint (check the path)",
                path.string());
    }
    void read(void* data, std::size_t size)
    {
        in_.read(static_cast<char*>(data), static_cast<std::streamsize>(size));
        require(static_cast<std::size_t>(in_.gcount()) == size,
                "{}: the checkpoint is cut short (render again without --resume)", path_.string());
        hash_ = hash_bytes(data, size, hash_);
    }
    std::uint64_t hash() const { return hash_; }
    bool at_end() { return in_.peek() == std::ifstream::traits_type::eof(); }

private:
    fs::path path_;
    std::ifstream in_;
    std::uint64_t hash_ = 0;
};

struct Header {
    int width = 0, height = 0;
    std::int64_t samples = 0;
    Fingerprint fingerprint;
};

Header parse_header(const std::string& text, const std::string& name)
{
    const ordered_json json = parse_json(text, name);
    const ObjectReader reader(json, JsonPlace{name, ""}, {"width", "height", "samples", "fingerprint"});
    Header header;
    reader.required("width");
    reader.whole("width", header.width, 1, 16384);
    reader.required("height");
    reader.whole("height", header.height, 1, 16384);
    header.samples = static_cast<std::int64_t>(
        read_whole(reader.required("samples"), reader.place("samples"), 0, std::numeric_limits<std::int32_t>::max()));
    const ordered_json& fingerprint = reader.required("fingerprint");
    require(fingerprint.is_object(), "{}: the checkpoint has no fingerprint (render again without --resume)", name);
    for (const auto& item : fingerprint.items())
        header.fingerprint[item.key()] = read_string(item.value(), reader.place("fingerprint").at(item.key()));
    return header;
}

} // namespace

void write_checkpoint(const fs::path& file, const Film& film, const Fingerprint& fingerprint)
{
    fs::path beside = file;
    beside += ".partial"; // a fixed name: what a killed run left behind is replaced by the next
    {
        OutputFile out(beside);
        const std::string header = header_text(film, fingerprint);
        const std::array<std::uint32_t, 2> sizes{format_version, static_cast<std::uint32_t>(header.size())};
        out.write(magic.data(), magic.size());
        out.write(sizes.data(), sizeof(sizes));
        out.write(header.data(), header.size());
        out.write(film.arrays().color_sum.data(), film.arrays().color_sum.bytes());
        out.write(film.arrays().color_sum_squares.data(), film.arrays().color_sum_squares.bytes());
        out.write(film.arrays().block_sum_squares.data(), film.arrays().block_sum_squares.bytes());
        out.write(film.arrays().block_begin.data(), film.arrays().block_begin.bytes());
        out.write(film.arrays().features.data(), film.arrays().features.bytes());
        const std::uint64_t hash = out.hash();
        out.write(&hash, sizeof(hash));
        out.flush_to_disk();
    }
    std::error_code error;
    fs::rename(beside, file, error);
    require(!error, "{}: cannot write the checkpoint: {} (choose another name)", file.string(), error.message());
}

Film read_checkpoint(const fs::path& file, const Fingerprint& expected)
{
    InputFile in(file);
    std::array<char, 8> found_magic{};
    std::array<std::uint32_t, 2> sizes{};
    in.read(found_magic.data(), found_magic.size());
    require(std::string_view(found_magic.data(), found_magic.size()) == magic,
            "{}: is not a checkpoint of this program", file.string());
    in.read(sizes.data(), sizeof(sizes));
    require(sizes[0] == format_version,
            "{}: a checkpoint of format {}, this program reads {} (render again without --resume)", file.string(),
            sizes[0], format_version);
    require(sizes[1] <= (1U << 16), "{}: the checkpoint is damaged (render again without --resume)", file.string());
    std::string text(sizes[1], ' ');
    in.read(text.data(), text.size());
    const Header header = parse_header(text, file.string());
    const std::string differing = difference(header.fingerprint, expected);
    require(differing.empty(),
            "{}: is a checkpoint of another render, with another {} (resume with what it was written with)",
            file.string(), differing);

    const auto pixels = static_cast<std::uint64_t>(header.width) * static_cast<std::uint64_t>(header.height);
    const std::uint64_t film_bytes = pixels * (12 * sizeof(double) + feature_count * sizeof(float));
    std::error_code error;
    require(fs::file_size(file, error) == preamble_bytes + text.size() + film_bytes + sizeof(std::uint64_t),
            "{}: the checkpoint is cut short or too long (render again without --resume)", file.string());
    require_memory(film_bytes, file.string(), "render a smaller image");
    Film film(header.width, header.height);
    in.read(film.arrays().color_sum.data(), film.arrays().color_sum.bytes());
    in.read(film.arrays().color_sum_squares.data(), film.arrays().color_sum_squares.bytes());
    in.read(film.arrays().block_sum_squares.data(), film.arrays().block_sum_squares.bytes());
    in.read(film.arrays().block_begin.data(), film.arrays().block_begin.bytes());
    in.read(film.arrays().features.data(), film.arrays().features.bytes());
    const std::uint64_t hash = in.hash();
    std::uint64_t stored_hash = 0;
    in.read(&stored_hash, sizeof(stored_hash));
    require(stored_hash == hash, "{}: the checkpoint is damaged, its checksum is wrong (render again without --resume)",
            file.string());
    film.set_samples(header.samples);
    return film;
}

} // namespace lumisweep
