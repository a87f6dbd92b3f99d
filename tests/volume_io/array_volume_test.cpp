// Volumes from arrays in memory: what is shared, what is copied, and that a shared one renders like its copy.
#include "lumisweep/volume/io/array_volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include <sys/mman.h>
#include <unistd.h>

#include "lumisweep/base/error.h"

namespace lumisweep {
namespace {

constexpr Vec3i size{5, 4, 3};
constexpr std::size_t count = 60;

/// Values in the middle of three pages of which the last cannot be read, so that touching it kills the test.
class Pages {
public:
    Pages() : page_(static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)))
    {
        memory_ = static_cast<std::byte*>(
            ::mmap(nullptr, 3 * page_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
        EXPECT_EQ(::mprotect(memory_ + 2 * page_, page_, PROT_NONE), 0);
    }
    ~Pages() { ::munmap(memory_, 3 * page_); }
    Pages(const Pages&) = delete;
    Pages& operator=(const Pages&) = delete;

    /// The array's last byte is `before_end` bytes before the last readable one.
    template <class T>
    T* array(std::size_t before_end)
    {
        return reinterpret_cast<T*>(memory_ + 2 * page_ - before_end - count * sizeof(T));
    }

private:
    std::size_t page_;
    std::byte* memory_;
};

template <class T>
ArrayVoxels voxels_of(const T* data, StoredType type)
{
    ArrayVoxels array;
    array.data = reinterpret_cast<const std::byte*>(data);
    array.type = type;
    array.size = size;
    array.owner = std::shared_ptr<const void>(data, [](const void*) {});
    return array;
}

std::string refusal(const ArrayVoxels& array)
{
    try {
        volume_from_array(array, Sharing::required);
        return "";
    } catch (const Error& error) {
        return error.what();
    }
}

TEST(ArrayVolume, SharesWhatKernelsCanReadAndCopiesTheRest)
{
    Pages pages;
    auto* values = pages.array<std::int16_t>(ScalarGrid::readable_behind);
    for (std::size_t i = 0; i < count; ++i)
        values[i] = static_cast<std::int16_t>(3 * i);
    const ArrayVolume shared = volume_from_array(voxels_of(values, StoredType::i16), Sharing::where_possible);
    EXPECT_FALSE(shared.grid.owns_voxels());
    EXPECT_EQ(static_cast<const void*>(std::as_const(shared.grid).data()), values);
    EXPECT_EQ(shared.grid.bytes(), count * sizeof(std::int16_t));
    EXPECT_EQ(shared.grid.value(1, 2, 1), 3.0 * (1 + 5 * (2 + 4 * 1)));
    values[0] = 77; // the array is what is read
    EXPECT_EQ(shared.grid.value(0, 0, 0), 77.0);

    const ArrayVolume copied = volume_from_array(voxels_of(values, StoredType::i16), Sharing::never);
    values[0] = 5;
    EXPECT_TRUE(copied.grid.owns_voxels());
    EXPECT_EQ(copied.grid.value(0, 0, 0), 77.0);

    // Two bytes too late for whole vectors at the last voxels.
    auto* late = pages.array<std::int16_t>(ScalarGrid::readable_behind - 2);
    EXPECT_TRUE(volume_from_array(voxels_of(late, StoredType::i16), Sharing::where_possible).grid.owns_voxels());
    EXPECT_NE(refusal(voxels_of(late, StoredType::i16)).find("last page"), std::string::npos);
}

TEST(ArrayVolume, KeepsItsOwnerAlive)
{
    Pages pages;
    bool alive = true;
    {
        ArrayVoxels array = voxels_of(pages.array<std::uint8_t>(256), StoredType::u8);
        array.owner = std::shared_ptr<const void>(
            &alive, [](const void* flag) { *static_cast<bool*>(const_cast<void*>(flag)) = false; });
        ArrayVolume volume = volume_from_array(array, Sharing::required);
        array.owner.reset();
        const ScalarGrid moved = std::move(volume.grid);
        EXPECT_TRUE(alive);
        EXPECT_EQ(moved.value(0, 0, 0), 0.0);
    }
    EXPECT_FALSE(alive);
}

TEST(ArrayVolume, ConvertsLikeFiles)
{
    std::vector<std::int64_t> wide(count, 300);
    wide[7] = 65535;
    const ArrayVolume small = volume_from_array(voxels_of(wide.data(), StoredType::i64), Sharing::where_possible);
    EXPECT_EQ(small.grid.type(), VoxelType::u16);
    EXPECT_EQ(small.grid.value(2, 1, 0), 65535.0);
    EXPECT_NE(refusal(voxels_of(wide.data(), StoredType::i64)).find("int64"), std::string::npos);

    std::vector<std::uint16_t> swapped(count, 0x0100);
    ArrayVoxels array = voxels_of(swapped.data(), StoredType::u16);
    array.order = ByteOrder::swapped;
    EXPECT_EQ(volume_from_array(array, Sharing::where_possible).grid.value(0, 0, 0), 1.0);
    EXPECT_NE(refusal(array).find("order"), std::string::npos);

    std::vector<std::byte> bytes(count * sizeof(float) + 1);
    EXPECT_NE(refusal(voxels_of(bytes.data() + 1, StoredType::f32)).find("aligned"), std::string::npos);
}

TEST(ArrayVolume, InfinityIsCopiedToNaNAndNaNIsShared)
{
    Pages pages;
    auto* values = pages.array<float>(1024);
    std::fill_n(values, count, 1.0F);
    values[3] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(volume_from_array(voxels_of(values, StoredType::f32), Sharing::required).grid.owns_voxels());
    values[4] = -std::numeric_limits<float>::infinity();
    const ArrayVolume copied = volume_from_array(voxels_of(values, StoredType::f32), Sharing::where_possible);
    EXPECT_TRUE(copied.grid.owns_voxels());
    EXPECT_TRUE(std::isnan(copied.grid.value(4, 0, 0)));
    ASSERT_EQ(copied.warnings.size(), 1U);
    EXPECT_NE(copied.warnings[0].find("2 of 60 voxels"), std::string::npos);
}

TEST(ArrayVolume, RefusesImpossibleSizesAndPlaces)
{
    std::vector<std::uint8_t> bytes(count);
    ArrayVoxels array = voxels_of(bytes.data(), StoredType::u8);
    array.size = {5, 0, 3};
    EXPECT_THROW(volume_from_array(array, Sharing::where_possible), Error);
    array.size = size;
    array.slope = 0.0;
    EXPECT_THROW(volume_from_array(array, Sharing::where_possible), Error);
    EXPECT_THROW(ScalarGrid(VoxelType::u8, size, Affine3d{}, nullptr), Error);
}

} // namespace
} // namespace lumisweep
