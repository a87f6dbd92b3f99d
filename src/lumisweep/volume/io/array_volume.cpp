#include "lumisweep/volume/io/array_volume.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <optional>

#include <fmt/format.h>
#include <unistd.h>

#include "lumisweep/base/error.h"
#include "lumisweep/base/parallel.h"

namespace lumisweep {

namespace {

constexpr const char* where = "array";

std::optional<VoxelType> kept_type(StoredType type)
{
    switch (type) {
    case StoredType::u8: return VoxelType::u8;
    case StoredType::u16: return VoxelType::u16;
    case StoredType::i16: return VoxelType::i16;
    case StoredType::f32: return VoxelType::f32;
    default: return std::nullopt;
    }
}

std::size_t count_of(const Vec3i& size) { return std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z); }

/// Pages are mapped as a whole.
bool readable_behind(const ArrayVoxels& array)
{
    const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    const std::uintptr_t end =
        reinterpret_cast<std::uintptr_t>(array.data) + count_of(array.size) * size_of(array.type);
    return (end - 1) / page == (end - 1 + ScalarGrid::readable_behind) / page;
}

bool any_infinite(const float* values, std::size_t count)
{
    std::atomic<bool> found = false;
    constexpr std::size_t run = std::size_t(1) << 16;
    parallel_for(std::size_t(0), (count + run - 1) / run, [&](std::size_t r) {
        bool here = false;
        for (std::size_t i = r * run; i < std::min(count, (r + 1) * run); ++i)
            here = here || std::isinf(values[i]);
        if (here)
            found = true;
    });
    return found;
}

} // namespace

bool any_infinite(const ScalarGrid& volume)
{
    return volume.type() == VoxelType::f32 && any_infinite(volume.voxels<float>(), volume.voxel_count());
}

std::string why_not_shared(const ArrayVoxels& array)
{
    const std::optional<VoxelType> type = kept_type(array.type);
    if (!type)
        return fmt::format("voxels of type {} have to be converted", name_of(array.type));
    if (array.order != ByteOrder::native)
        return "its bytes are in another order than this machine's";
    if (reinterpret_cast<std::uintptr_t>(array.data) % size_of(array.type) != 0)
        return "its voxels are not aligned";
    if (!readable_behind(array))
        return fmt::format("it ends less than {} bytes before its memory's last page does",
                           ScalarGrid::readable_behind);
    if (*type == VoxelType::f32 && any_infinite(reinterpret_cast<const float*>(array.data), count_of(array.size)))
        return "it has infinite values, which have to become NaN";
    return {};
}

ArrayVolume volume_from_array(const ArrayVoxels& array, Sharing sharing)
{
    require(array.size.x >= 1 && array.size.y >= 1 && array.size.z >= 1,
            "{}: {} x {} x {} voxels (give at least one along each axis)", where, array.size.x, array.size.y,
            array.size.z);
    if (sharing != Sharing::never) {
        const std::string reason = why_not_shared(array);
        if (reason.empty())
            return {ScalarGrid(*kept_type(array.type), array.size, array.world_from_voxel,
                               std::shared_ptr<const std::byte>(array.owner, array.data), array.slope, array.intercept),
                    {}};
        require(sharing != Sharing::required, "{}: cannot be shared, {} (allow a copy)", where, reason);
    }
    VolumeHeader header;
    header.size = array.size;
    header.world_from_voxel = array.world_from_voxel;
    header.slope = array.slope;
    header.intercept = array.intercept;
    const std::uint64_t bytes = count_of(array.size) * size_of(array.type);
    MemoryVoxels source(array.owner, array.data, FrameLayout{bytes, 1, 1}, 0);
    ArrayVolume volume;
    volume.grid = read_grid(source, array.type, array.order, header, where, volume.warnings);
    const std::size_t infinite_or_nan = volume.grid.mark_non_finite();
    if (infinite_or_nan > 0)
        volume.warnings.push_back(fmt::format("{}: {} of {} voxels are NaN or infinite and count as empty", where,
                                              infinite_or_nan, volume.grid.voxel_count()));
    return volume;
}

} // namespace lumisweep
