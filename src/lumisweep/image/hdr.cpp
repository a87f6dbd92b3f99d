#include "lumisweep/image/hdr.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/image/exr.h"

namespace lumisweep {
namespace {

constexpr int max_size = 65536;
constexpr std::size_t max_header_line = 4096;

using Rgbe = std::array<std::uint8_t, 4>;

/// A number that is all of `text`.
template <class T>
std::optional<T> parse_number(std::string_view text)
{
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

std::string_view trimmed(std::string_view text)
{
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t'))
        text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r'))
        text.remove_suffix(1);
    return text;
}

class HdrReader {
public:
    HdrReader(std::span<const std::byte> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

    Image read()
    {
        read_header();
        const auto width = static_cast<std::size_t>(image_.width), height = static_cast<std::size_t>(image_.height);
        // Each row takes four bytes at least, in either coding: a short file cannot claim many rows.
        require(height <= (bytes_.size() - position_) / 4, "{}: {} x {} pixels in {} bytes: truncated (get it again)",
                name_, width, height, bytes_.size());
        require_memory(12 * width * height, fmt::format("{} with {} x {} pixels", name_, width, height),
                       "use a smaller image");
        for (const char* channel : {"R", "G", "B"})
            image_.channels.push_back({channel, std::vector<float>(width * height)});
        std::vector<Rgbe> row(width);
        for (std::size_t y = 0; y < height; ++y) {
            read_row(row);
            convert(row, y * width);
        }
        return std::move(image_);
    }

private:
    std::uint8_t next()
    {
        require(position_ < bytes_.size(), "{}: its pixels end too early: the file is truncated (get it again)", name_);
        return static_cast<std::uint8_t>(bytes_[position_++]);
    }

    std::string_view next_line()
    {
        const auto* begin = reinterpret_cast<const char*>(bytes_.data()) + position_;
        const std::string_view rest(begin, std::min(bytes_.size() - position_, max_header_line));
        const std::size_t end = rest.find('\n');
        require(end != std::string_view::npos,
                "{}: its header does not end: not a sound Radiance picture (get it again)", name_);
        position_ += end + 1;
        return trimmed(rest.substr(0, end));
    }

    void read_header()
    {
        require(bytes_.size() >= 2 && bytes_[0] == std::byte{'#'} && bytes_[1] == std::byte{'?'},
                "{}: not a Radiance picture (its first bytes say otherwise)", name_);
        next_line();
        for (std::string_view line = next_line(); !line.empty(); line = next_line()) {
            constexpr std::string_view format = "FORMAT=", exposure = "EXPOSURE=";
            if (line.starts_with(format)) {
                require(trimmed(line.substr(format.size())) == "32-bit_rle_rgbe",
                        "{}: its pixels are not 32-bit_rle_rgbe (save it as RGBE)", name_);
            } else if (line.starts_with(exposure)) {
                const std::optional<double> value = parse_number<double>(trimmed(line.substr(exposure.size())));
                require(value && std::isfinite(*value) && *value > 0.0,
                        "{}: its EXPOSURE is no positive number (mend it)", name_);
                exposure_ *= *value;
            }
        }
        require(std::isfinite(1.0 / exposure_) && exposure_ > 0.0 && std::isfinite(exposure_),
                "{}: its EXPOSURE lines multiply to {} (mend them)", name_, exposure_);
        read_resolution(next_line());
    }

    void read_resolution(std::string_view line)
    {
        std::array<std::string_view, 4> word{};
        std::size_t count = 0;
        while (!line.empty() && count < word.size()) {
            const std::size_t end = std::min(line.find(' '), line.size());
            word[count++] = line.substr(0, end);
            line = trimmed(line.substr(end));
        }
        const bool is_resolution = count == 4 && line.empty() && word[0].size() == 2 && word[2].size() == 2;
        require(is_resolution, "{}: no resolution like '-Y 512 +X 1024' after its header (get it again)", name_);
        require(word[0] == "-Y" && word[2] == "+X",
                "{}: its rows or columns run another way than -Y, +X (turn or flip it into the usual orientation)",
                name_);
        const std::optional<int> height = parse_number<int>(word[1]), width = parse_number<int>(word[3]);
        require(width && height && *width >= 1 && *height >= 1 && *width <= max_size && *height <= max_size,
                "{}: its resolution is not from 1 to {} pixels each way", name_, max_size);
        image_.width = *width;
        image_.height = *height;
    }

    void read_row(std::vector<Rgbe>& row)
    {
        const Rgbe first{next(), next(), next(), next()};
        const bool is_new_coding =
            row.size() >= 8 && row.size() < 32768 && first[0] == 2 && first[1] == 2 && first[2] < 128;
        if (!is_new_coding)
            return read_old_row(first, row);
        require(static_cast<std::size_t>(first[2] * 256 + first[3]) == row.size(),
                "{}: a row of {} pixels where there are {} (the file is broken)", name_, first[2] * 256 + first[3],
                row.size());
        for (std::size_t c = 0; c < 4; ++c)
            for (std::size_t x = 0; x < row.size();)
                x += read_run(row, x, c);
    }

    /// Component c of some pixels from x on; returns how many.
    std::size_t read_run(std::vector<Rgbe>& row, std::size_t x, std::size_t c)
    {
        const std::uint8_t code = next();
        const std::size_t count = code > 128 ? code - 128U : code;
        require(count >= 1 && count <= row.size() - x, "{}: a run leaves its row (the file is broken)", name_);
        const std::uint8_t repeated = code > 128 ? next() : std::uint8_t{0};
        for (std::size_t i = x; i < x + count; ++i)
            row[i][c] = code > 128 ? repeated : next();
        return count;
    }

    /// Plain pixels, where (1, 1, 1, n) repeats the pixel before n times; codes in succession count 256 times as much.
    void read_old_row(const Rgbe& first, std::vector<Rgbe>& row)
    {
        int shift = 0;
        for (std::size_t x = 0; x < row.size();) {
            const Rgbe pixel = x == 0 ? first : Rgbe{next(), next(), next(), next()};
            if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
                row[x++] = pixel;
                shift = 0;
                continue;
            }
            require(x > 0 && shift <= 16, "{}: a run repeats nothing (the file is broken)", name_);
            const std::size_t count = static_cast<std::size_t>(pixel[3]) << shift;
            require(count <= row.size() - x, "{}: a run leaves its row (the file is broken)", name_);
            std::fill_n(row.begin() + static_cast<std::ptrdiff_t>(x), count, row[x - 1]);
            x += count;
            shift += 8;
        }
    }

    void convert(const std::vector<Rgbe>& row, std::size_t begin)
    {
        for (std::size_t c = 0; c < 3; ++c) {
            float* out = image_.channels[c].pixels.data() + begin;
            for (std::size_t x = 0; x < row.size(); ++x)
                out[x] =
                    row[x][3] == 0 ? 0.0F : static_cast<float>(std::ldexp(row[x][c], int{row[x][3]} - 136) / exposure_);
        }
    }

    std::span<const std::byte> bytes_;
    std::string name_;
    std::size_t position_ = 0;
    double exposure_ = 1.0;
    Image image_;
};

std::vector<std::byte> read_bytes(const std::filesystem::path& path, std::uint64_t at_most)
{
    std::error_code error;
    const bool is_file = std::filesystem::is_regular_file(path, error);
    require(is_file, "{}: no such file (check the name)", path.string());
    const std::uint64_t size = std::min<std::uint64_t>(std::filesystem::file_size(path, error), at_most);
    std::ifstream file(path, std::ios::binary);
    require(!error && file.is_open(), "{}: cannot be opened (check its permissions)", path.string());
    require_memory(size, path.string(), "use a smaller image");
    std::vector<std::byte> bytes(size);
    file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    require(static_cast<std::uint64_t>(file.gcount()) == size, "{}: reading failed (check the disk)", path.string());
    return bytes;
}

} // namespace

Image read_hdr(std::span<const std::byte> bytes, const std::string& name) { return HdrReader(bytes, name).read(); }

Image read_hdr(const std::filesystem::path& path)
{
    return read_hdr(read_bytes(path, static_cast<std::uint64_t>(-1)), path.string());
}

Image load_latlong(const std::filesystem::path& path)
{
    const std::vector<std::byte> magic = read_bytes(path, 4);
    const auto starts_with = [&](std::string_view text) {
        return magic.size() >= text.size() &&
               std::equal(text.begin(), text.end(), magic.begin(),
                          [](char a, std::byte b) { return static_cast<std::byte>(a) == b; });
    };
    const bool is_exr = starts_with("\x76\x2f\x31\x01"), is_hdr = starts_with("#?");
    require(is_exr || is_hdr, "{}: neither an OpenEXR nor a Radiance picture (give an .exr or .hdr environment map)",
            path.string());
    Image image = is_exr ? read_exr(path) : read_hdr(path);
    for (const char* name : {"R", "G", "B"})
        require(image.find(name), "{}: no channel {} (an environment map needs R, G and B, or Y)", path.string(), name);
    return image;
}

} // namespace lumisweep
