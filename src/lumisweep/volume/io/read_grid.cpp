#include "lumisweep/volume/io/read_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"

namespace lumisweep {

namespace {

constexpr std::size_t chunk_voxels = std::size_t(1) << 16;

template <class T>
void swap_bytes(T* values, std::size_t count)
{
    if constexpr (sizeof(T) > 1)
        for (std::size_t i = 0; i < count; ++i) {
            auto* bytes = reinterpret_cast<unsigned char*>(values + i);
            std::reverse(bytes, bytes + sizeof(T));
        }
}

/// Calls f(const T*, n) for runs of voxels in native byte order, from the frame's start to its end.
template <class T, class Function>
void for_each_chunk(VoxelSource& source, ByteOrder order, std::size_t count, Function&& f)
{
    std::vector<T> chunk(std::min(chunk_voxels, count));
    source.rewind();
    for (std::size_t done = 0; done < count; done += chunk.size()) {
        const std::size_t n = std::min(chunk.size(), count - done);
        source.read(std::as_writable_bytes(std::span(chunk.data(), n)));
        if (order == ByteOrder::swapped)
            swap_bytes(chunk.data(), n);
        f(chunk.data(), n);
    }
}

/// What decides the type in memory: the range, and what a float would lose.
struct Survey {
    bool integral = true;
    std::uint64_t rounded = 0; // values that float cannot hold exactly
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();
};

template <class T>
Survey survey(VoxelSource& source, ByteOrder order, std::size_t count)
{
    Survey s;
    for_each_chunk<T>(source, order, count, [&](const T* values, std::size_t n) {
        for (std::size_t i = 0; i < n; ++i) {
            const double v = static_cast<double>(values[i]);
            s.low = std::min(s.low, v);
            s.high = std::max(s.high, v);
            if constexpr (std::is_floating_point_v<T>) {
                s.integral = s.integral && std::isfinite(v) && v == std::floor(v);
                s.rounded += std::isfinite(v) && double(static_cast<float>(v)) != v ? 1 : 0;
            } else {
                // A 64-bit integer that changes on its way through float; 2^63 and 2^64 themselves do not convert back.
                const float f = static_cast<float>(values[i]);
                const bool fits = f < static_cast<float>(std::numeric_limits<T>::max());
                s.rounded += !fits || static_cast<T>(f) != values[i] ? 1 : 0;
            }
        }
    });
    return s;
}

VoxelType smallest_type(const Survey& s)
{
    if (!s.integral)
        return VoxelType::f32;
    if (s.low >= 0 && s.high <= 255)
        return VoxelType::u8;
    if (s.low >= 0 && s.high <= 65535)
        return VoxelType::u16;
    if (s.low >= -32768 && s.high <= 32767)
        return VoxelType::i16;
    return VoxelType::f32;
}

struct Job {
    VoxelSource& source;
    ByteOrder order;
    const VolumeHeader& header;
    const std::string& where;
};

ScalarGrid take_grid(const Job& job, VoxelType type)
{
    const Vec3i size = job.header.size;
    const std::uint64_t count = std::uint64_t(size.x) * std::uint64_t(size.y) * std::uint64_t(size.z);
    require_memory(count * size_of(type), job.where, "crop or downsample the volume, or free memory");
    return {type, size, job.header.world_from_voxel, job.header.slope, job.header.intercept};
}

template <class Stored, class Kept>
ScalarGrid convert(const Job& job, VoxelType type)
{
    ScalarGrid grid = take_grid(job, type);
    Kept* out = grid.voxels<Kept>();
    if constexpr (std::is_same_v<Stored, Kept>) {
        job.source.rewind();
        job.source.read({grid.data(), grid.voxel_count() * sizeof(Kept)});
        if (job.order == ByteOrder::swapped)
            swap_bytes(out, grid.voxel_count());
    } else {
        for_each_chunk<Stored>(job.source, job.order, grid.voxel_count(), [&](const Stored* values, std::size_t n) {
            out = std::transform(values, values + n, out, [](Stored v) { return static_cast<Kept>(v); });
        });
    }
    return grid;
}

template <class Stored>
ScalarGrid shrink(const Job& job, std::vector<std::string>& warnings)
{
    const Vec3i size = job.header.size;
    const std::size_t count = std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z);
    const Survey s = survey<Stored>(job.source, job.order, count);
    switch (const VoxelType type = smallest_type(s)) {
    case VoxelType::u8: return convert<Stored, std::uint8_t>(job, type);
    case VoxelType::u16: return convert<Stored, std::uint16_t>(job, type);
    case VoxelType::i16: return convert<Stored, std::int16_t>(job, type);
    default:
        if (s.rounded > 0)
            warnings.push_back(
                fmt::format("{}: {} of {} voxels are rounded to 32-bit floats", job.where, s.rounded, count));
        return convert<Stored, float>(job, type);
    }
}

} // namespace

std::size_t size_of(StoredType type)
{
    constexpr std::array<std::size_t, 10> sizes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}

const char* name_of(StoredType type)
{
    constexpr std::array names{"int8",   "uint8", "int16",  "uint16",  "int32",
                               "uint32", "int64", "uint64", "float32", "float64"};
    return names[static_cast<std::size_t>(type)];
}

std::size_t loaded_size_of(StoredType type)
{
    return type == StoredType::i8 ? 2 : std::min<std::size_t>(size_of(type), 4);
}

ScalarGrid read_grid(VoxelSource& source, StoredType type, ByteOrder order, const VolumeHeader& header,
                     const std::string& where, std::vector<std::string>& warnings)
{
    const Job job{source, order, header, where};
    switch (type) {
    case StoredType::i8: return convert<std::int8_t, std::int16_t>(job, VoxelType::i16);
    case StoredType::u8: return convert<std::uint8_t, std::uint8_t>(job, VoxelType::u8);
    case StoredType::i16: return convert<std::int16_t, std::int16_t>(job, VoxelType::i16);
    case StoredType::u16: return convert<std::uint16_t, std::uint16_t>(job, VoxelType::u16);
    case StoredType::f32: return convert<float, float>(job, VoxelType::f32);
    case StoredType::i32: return shrink<std::int32_t>(job, warnings);
    case StoredType::u32: return shrink<std::uint32_t>(job, warnings);
    case StoredType::i64: return shrink<std::int64_t>(job, warnings);
    case StoredType::u64: return shrink<std::uint64_t>(job, warnings);
    default: return shrink<double>(job, warnings);
    }
}

} // namespace lumisweep
