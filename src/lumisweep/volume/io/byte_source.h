// A file's bytes from some offset on, decompressed if need be, read front to back in bounded memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

namespace lumisweep {

enum class Compression { none, deflate }; ///< deflate: gzip or zlib wrapping, told apart by their first bytes

class ByteSource {
public:
    /// Opens the file; `offset` counts in the file itself, before decompression. Throws Error when it cannot be opened.
    ByteSource(const std::filesystem::path& path, std::uint64_t offset, Compression compression);
    ~ByteSource();
    ByteSource(const ByteSource&) = delete;
    ByteSource& operator=(const ByteSource&) = delete;

    const std::filesystem::path& path() const { return path_; }
    /// Back to `offset`.
    void rewind();
    /// The next bytes; throws Error when the data end before `bytes` is full, or are damaged.
    void read(std::span<std::byte> bytes);
    void skip(std::uint64_t count);
    /// To be called after the last byte that is wanted: lets zlib compare the checksum that follows it, if one does.
    void check_end();

private:
    struct Inflater;

    void refill();
    std::size_t read_file(std::vector<std::byte>& into);
    void inflate_more();

    std::filesystem::path path_;
    std::uint64_t offset_;
    int file_ = -1;
    std::unique_ptr<Inflater> inflater_;
    std::vector<std::byte> buffer_; // of decompressed bytes; [begin_, end_) are still to be handed out
    std::size_t begin_ = 0, end_ = 0;
};

/// deflate when the file begins with gzip's magic bytes, whatever its name.
Compression gzip_or_none(const std::filesystem::path& path);

/// Throws Error unless `path` can hold `bytes` of data from `offset` on: exactly for uncompressed data, up to deflate's
/// largest ratio (1032 : 1) for compressed ones. Catches truncated files and lying headers before memory is taken.
void require_plausible_size(const std::filesystem::path& path, std::uint64_t offset, Compression compression,
                            std::uint64_t bytes);

} // namespace lumisweep
