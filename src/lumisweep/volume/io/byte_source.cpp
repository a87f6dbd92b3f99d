#include "lumisweep/volume/io/byte_source.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include "lumisweep/base/error.h"

namespace lumisweep {

namespace {

constexpr std::size_t buffer_bytes = std::size_t(1) << 18;

} // namespace

struct ByteSource::Inflater {
    explicit Inflater(const std::filesystem::path& path) : input(buffer_bytes)
    {
        // 15 bits of window, + 32: gzip or zlib header, detected.
        require(inflateInit2(&stream, 15 + 32) == Z_OK, "{}: zlib cannot start", path.string());
    }
    ~Inflater() { inflateEnd(&stream); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;

    z_stream stream{};
    std::vector<std::byte> input;
};

ByteSource::ByteSource(const std::filesystem::path& path, std::uint64_t offset, Compression compression)
    : path_(path), offset_(offset), buffer_(buffer_bytes)
{
    if (compression == Compression::deflate)
        inflater_ = std::make_unique<Inflater>(path);
    file_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    require(file_ >= 0, "{}: cannot be opened, {} (check the path and its permissions)", path.string(),
            std::strerror(errno));
    rewind();
}

ByteSource::~ByteSource()
{
    if (file_ >= 0)
        close(file_);
}

void ByteSource::rewind()
{
    const bool ok = offset_ <= std::uint64_t(std::numeric_limits<off_t>::max()) &&
                    lseek(file_, static_cast<off_t>(offset_), SEEK_SET) >= 0;
    if (!ok) {
        close(file_);
        file_ = -1;
        fail("{}: cannot be read from byte {} on (give a regular file)", path_.string(), offset_);
    }
    begin_ = end_ = 0;
    if (inflater_) {
        inflateReset(&inflater_->stream);
        inflater_->stream.avail_in = 0;
    }
}

std::size_t ByteSource::read_file(std::vector<std::byte>& into)
{
    for (;;) {
        const ssize_t n = ::read(file_, into.data(), into.size());
        if (n >= 0)
            return static_cast<std::size_t>(n);
        require(errno == EINTR, "{}: cannot be read, {}", path_.string(), std::strerror(errno));
    }
}

void ByteSource::inflate_more()
{
    z_stream& stream = inflater_->stream;
    stream.next_out = reinterpret_cast<Bytef*>(buffer_.data());
    stream.avail_out = static_cast<uInt>(buffer_.size());
    while (stream.avail_out == buffer_.size()) {
        if (stream.avail_in == 0) {
            const std::size_t n = read_file(inflater_->input);
            if (n == 0)
                break; // end of file: refill() reports it
            stream.next_in = reinterpret_cast<Bytef*>(inflater_->input.data());
            stream.avail_in = static_cast<uInt>(n);
        }
        const int status = inflate(&stream, Z_NO_FLUSH);
        if (status == Z_STREAM_END)
            inflateReset(&stream); // gzip files may be several members in a row
        else
            require(status == Z_OK || status == Z_BUF_ERROR,
                    "{}: the compressed data are damaged, {} (copy or export the file again)", path_.string(),
                    stream.msg ? stream.msg : "zlib cannot go on");
    }
    end_ = buffer_.size() - stream.avail_out;
}

void ByteSource::refill()
{
    begin_ = end_ = 0;
    if (inflater_)
        inflate_more();
    else
        end_ = read_file(buffer_);
    require(end_ > 0, "{}: the data end too early (the file is truncated; copy or export it again)", path_.string());
}

void ByteSource::read(std::span<std::byte> bytes)
{
    while (!bytes.empty()) {
        if (begin_ == end_)
            refill();
        const std::size_t n = std::min(bytes.size(), end_ - begin_);
        std::memcpy(bytes.data(), buffer_.data() + begin_, n);
        begin_ += n;
        bytes = bytes.subspan(n);
    }
}

void ByteSource::skip(std::uint64_t count)
{
    while (count > 0) {
        if (begin_ == end_) {
            // A seek past the end is noticed by the next read.
            if (!inflater_ && count > buffer_bytes && count <= std::uint64_t(std::numeric_limits<off_t>::max()) &&
                lseek(file_, static_cast<off_t>(count), SEEK_CUR) >= 0)
                return;
            refill();
        }
        const std::uint64_t n = std::min<std::uint64_t>(count, end_ - begin_);
        begin_ += static_cast<std::size_t>(n);
        count -= n;
    }
}

void ByteSource::check_end()
{
    if (inflater_ && begin_ == end_) {
        begin_ = end_ = 0;
        inflate_more();
    }
}

Compression gzip_or_none(const std::filesystem::path& path)
{
    std::ifstream in(path, std::ios::binary);
    return in.get() == 0x1f && in.get() == 0x8b ? Compression::deflate : Compression::none;
}

void require_plausible_size(const std::filesystem::path& path, std::uint64_t offset, Compression compression,
                            std::uint64_t bytes)
{
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(path, error);
    require(!error, "{}: cannot be read, {} (check the path and its permissions)", path.string(), error.message());
    const std::uint64_t stored = size - std::min(size, offset);
    const std::uint64_t largest = compression == Compression::none ? stored
                                  : stored > std::numeric_limits<std::uint64_t>::max() / 2048
                                      ? std::numeric_limits<std::uint64_t>::max()
                                      : stored * 1032;
    require(
        bytes <= largest,
        "{}: the header promises {} bytes of voxels, the file holds {}{} (it is truncated or its header is wrong; copy "
        "or export it again)",
        path.string(), bytes, compression == Compression::none ? "" : "at most ", largest);
}

} // namespace lumisweep
