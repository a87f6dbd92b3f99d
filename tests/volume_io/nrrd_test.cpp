#include <limits>

#include <gmock/gmock.h>

#include "volume_io/test_files.h"

namespace lumisweep::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string nrrd(const std::string& fields, const std::string& data) { return "NRRD0004\n" + fields + "\n" + data; }

template <class T>
const char* nrrd_name()
{
    if constexpr (std::is_same_v<T, std::int8_t>)
        return "int8";
    else if constexpr (std::is_same_v<T, std::uint8_t>)
        return "uint8";
    else if constexpr (std::is_same_v<T, std::int16_t>)
        return "int16";
    else if constexpr (std::is_same_v<T, std::uint16_t>)
        return "uint16";
    else if constexpr (std::is_same_v<T, std::int32_t>)
        return "int32";
    else if constexpr (std::is_same_v<T, std::uint32_t>)
        return "uint32";
    else if constexpr (std::is_same_v<T, std::int64_t>)
        return "int64";
    else if constexpr (std::is_same_v<T, std::uint64_t>)
        return "uint64";
    else if constexpr (std::is_same_v<T, float>)
        return "float";
    else
        return "double";
}

/// A row of values as a 1-voxel-high volume.
template <class T>
LoadedVolume load_row(const std::vector<T>& values, const std::string& endian = "little")
{
    const TempDir dir;
    const auto file = dir.write("row.nrrd", nrrd("type: " + std::string(nrrd_name<T>()) +
                                                     "\ndimension: 3\nsizes: " + std::to_string(values.size()) +
                                                     " 1 1\nspacings: 1 1 1\nencoding: raw\nendian: " + endian + "\n",
                                                 endian == "little" ? bytes_of(values) : swapped_bytes_of(values)));
    return load(file);
}

template <class T>
void expect_kept(const std::vector<T>& values, VoxelType type)
{
    for (const char* endian : {"little", "big"}) {
        SCOPED_TRACE(endian);
        const LoadedVolume v = load_row(values, endian);
        EXPECT_STREQ(name_of(v.grid.type()), name_of(type));
        EXPECT_THAT(v.warnings, IsEmpty());
        for (std::size_t i = 0; i < values.size(); ++i)
            EXPECT_EQ(v.grid.value(int(i), 0, 0), double(values[i]));
    }
}

TEST(NrrdTypes, SmallTypesAreKept)
{
    expect_kept<std::uint8_t>({0, 1, 255}, VoxelType::u8);
    expect_kept<std::uint16_t>({0, 256, 65535}, VoxelType::u16);
    expect_kept<std::int16_t>({-32768, -2, 32767}, VoxelType::i16);
    expect_kept<float>({-1.5F, 0.1F, 3e30F}, VoxelType::f32);
    expect_kept<std::int8_t>({-128, -1, 127}, VoxelType::i16);
}

TEST(NrrdTypes, WideTypesBecomeTheSmallestThatHoldsThem)
{
    expect_kept<std::int32_t>({0, 7, 255}, VoxelType::u8);
    expect_kept<std::int32_t>({0, 7, 256}, VoxelType::u16);
    expect_kept<std::int32_t>({-1, 7, 255}, VoxelType::i16);
    expect_kept<std::int32_t>({-1, 7, 32768}, VoxelType::f32);
    expect_kept<std::uint32_t>({0, 65535}, VoxelType::u16);
    expect_kept<std::uint32_t>({0, 65536}, VoxelType::f32);
    expect_kept<std::int64_t>({-1024, 3071}, VoxelType::i16);
    expect_kept<std::uint64_t>({0, 65535}, VoxelType::u16);
    expect_kept<double>({-1024.0, 3071.0}, VoxelType::i16);
    expect_kept<double>({0.5, 255.0}, VoxelType::f32);
}

TEST(NrrdTypes, LostDigitsAreCounted)
{
    const LoadedVolume integers = load_row<std::int32_t>({16777217, 5, -16777219});
    EXPECT_EQ(integers.grid.type(), VoxelType::f32);
    ASSERT_EQ(integers.warnings.size(), 1U);
    EXPECT_THAT(integers.warnings[0], HasSubstr("2 of 3 voxels are rounded"));
    const LoadedVolume limits =
        load_row<std::uint64_t>({std::numeric_limits<std::uint64_t>::max(), std::uint64_t(1) << 63});
    ASSERT_EQ(limits.warnings.size(), 1U);
    EXPECT_THAT(limits.warnings[0], HasSubstr("1 of 2 voxels are rounded"));
    const LoadedVolume doubles = load_row<double>({0.1, 0.25});
    ASSERT_EQ(doubles.warnings.size(), 1U);
    EXPECT_THAT(doubles.warnings[0], HasSubstr("1 of 2 voxels are rounded"));
}

TEST(NrrdTypes, NonFiniteVoxelsAreMarkedAndCounted)
{
    const float inf = std::numeric_limits<float>::infinity();
    const LoadedVolume v = load_row<float>({1.0F, inf, -inf, std::nanf(""), 2.0F});
    EXPECT_EQ(v.non_finite, 3U);
    ASSERT_EQ(v.warnings.size(), 1U);
    EXPECT_THAT(v.warnings[0], HasSubstr("3 of 5 voxels are NaN or infinite"));
    for (int i : {1, 2, 3})
        EXPECT_TRUE(std::isnan(v.grid.value(i, 0, 0)));
    EXPECT_EQ(v.grid.value(4, 0, 0), 2.0);
    EXPECT_EQ(load_row<double>({1.0, std::nan(""), 1e300}).non_finite, 2U); // 1e300 is no float
}

TEST(NrrdEncodings, AllHoldTheSameVoxels)
{
    const TempDir dir;
    const std::string raw = bytes_of(ramp<std::int16_t>(5, 4, 3));
    std::string ascii, hex;
    for (int v : ramp<int>(5, 4, 3))
        ascii += std::to_string(v) + " ";
    for (unsigned char c : raw) {
        hex += "0123456789abcdef"[c >> 4];
        hex += "0123456789abcdef"[c & 15];
    }
    const std::string start = "type: short\ndimension: 3\nsizes: 5 4 3\nspacings: 1 1 1\nendian: little\n";
    const std::vector<std::filesystem::path> files{
        dir.write("raw.nrrd", nrrd(start + "encoding: raw\n", raw)),
        dir.write("gzip.nrrd", nrrd(start + "encoding: gzip\n", deflated(raw, Wrapping::gzip))),
        dir.write("members.nrrd", nrrd(start + "encoding: gzip\n", deflated(raw.substr(0, 50), Wrapping::gzip) +
                                                                       deflated(raw.substr(50), Wrapping::gzip))),
        dir.write("ascii.nrrd", nrrd(start + "encoding: ascii\n", ascii)),
        dir.write("hex.nrrd", nrrd(start + "encoding: hex\n", hex)),
        dir.write("skip.nrrd", nrrd(start + "encoding: raw\nbyte skip: 7\n", "1234567" + raw)),
        dir.write("tail.nrrd", nrrd(start + "encoding: raw\nbyte skip: -1\n", "anything" + raw)),
        dir.write("detached.nhdr", nrrd(start + "encoding: raw\ndata file: sub/voxels.raw\n", "")),
        dir.write("list.nhdr", "NRRD0004\n" + start + "encoding: raw\ndata file: LIST\nz0.raw\nz1.raw\nz2.raw\n"),
        dir.write("pattern.nhdr", nrrd(start + "encoding: raw\ndata file: z%d.raw 0 2 1\n", ""))};
    dir.write("sub/voxels.raw", raw);
    for (int k = 0; k < 3; ++k)
        dir.write(fmt::format("z{}.raw", k), raw.substr(std::size_t(k) * 40, 40));
    for (const auto& file : files) {
        SCOPED_TRACE(file.filename());
        const LoadedVolume v = load(file);
        EXPECT_EQ(v.grid.type(), VoxelType::i16);
        EXPECT_EQ(v.format, "NRRD");
        expect_ramp(v.grid, {5, 4, 3});
    }
}

TEST(NrrdGeometry, EverySpaceComesOutInLps)
{
    // A sheared-free oblique frame in the file's own axes: x along the second coordinate, spacing 2, 3, 4.
    const struct {
        const char* space;
        Vec3d sign;
    } cases[] = {{"left-posterior-superior", {1, 1, 1}},   {"LPS", {1, 1, 1}},
                 {"right-anterior-superior", {-1, -1, 1}}, {"RAS", {-1, -1, 1}},
                 {"left-anterior-superior", {1, -1, 1}},   {"scanner-xyz", {1, 1, 1}}};
    for (const auto& c : cases) {
        SCOPED_TRACE(c.space);
        const TempDir dir;
        const auto file = dir.write(
            "v.nrrd",
            nrrd(std::string("type: uchar\ndimension: 3\nspace: ") + c.space +
                     "\nsizes: 2 2 2\nspace directions: (0,2,0) (-2.4,0,1.8) (0,0,4)\nspace origin: (10,20,30)\n"
                     "encoding: raw\n",
                 bytes_of(ramp<std::uint8_t>(2, 2, 1, 2))));
        const LoadedVolume v = load(file);
        const auto lps = [&](const Vec3d& p) { return p * c.sign; };
        expect_point(sample_position(v.grid, 0, 0, 0), lps({10, 20, 30}));
        expect_point(sample_position(v.grid, 1, 0, 0), lps({10, 22, 30}));
        expect_point(sample_position(v.grid, 0, 1, 0), lps({7.6, 20, 31.8}));
        expect_point(sample_position(v.grid, 0, 0, 1), lps({10, 20, 34}));
        const VolumeHeader h = inspect_volume(file);
        expect_point(h.spacing, {2, 3, 4});
        EXPECT_THAT(v.warnings, IsEmpty());
    }
}

TEST(NrrdGeometry, WithoutSpace)
{
    const TempDir dir;
    const std::string start = "type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n";
    const std::string data(8, 'x');
    // Cell-centred: the minimum is the border of the first voxel.
    LoadedVolume v = load(dir.write("a.nrrd", nrrd(start + "spacings: 2 3 4\naxis mins: 10 0 -4\n", data)));
    expect_point(v.grid.world_from_voxel().point({0, 0, 0}), {10, 0, -4});
    expect_point(v.grid.world_from_voxel().point({2, 2, 2}), {14, 6, 4});
    v = load(dir.write("b.nrrd", nrrd(start + "spacings: 2 -3 4\n", data)));
    expect_point(sample_position(v.grid, 1, 1, 1), {2, -3, 4}); // runs backwards
    v = load(dir.write("c.nrrd", nrrd(start, data)));
    expect_point(sample_position(v.grid, 1, 1, 1), {1, 1, 1});
    EXPECT_EQ(v.warnings.size(), 3U);
    EXPECT_THAT(v.warnings.at(0), HasSubstr("1 mm is assumed"));
    v = load(dir.write("d.nrrd", nrrd(start + "space: LPS\nspacings: 2 3 4\n", data)));
    expect_point(sample_position(v.grid, 1, 1, 1), {2, 3, 4});
    ASSERT_EQ(v.warnings.size(), 1U);
    EXPECT_THAT(v.warnings.at(0), HasSubstr("LPS axes from origin 0 are assumed"));
}

TEST(NrrdGeometry, OtherUnitsAreSaid)
{
    const TempDir dir;
    const std::string start = "type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspace: LPS\n"
                              "space directions: (2,0,0) (0,2,0) (0,0,2)\nspace units: ";
    const std::string data(8, 'x');
    EXPECT_THAT(load(dir.write("a.nrrd", nrrd(start + "\"mm\" \"mm\" \"mm\"\n", data))).warnings, IsEmpty());
    const LoadedVolume v = load(dir.write("b.nrrd", nrrd(start + "\"um\" \"um\" \"um\"\n", data)));
    expect_point(sample_position(v.grid, 1, 1, 1), {2, 2, 2});
    ASSERT_EQ(v.warnings.size(), 1U);
    EXPECT_THAT(v.warnings.at(0), HasSubstr("units other than mm"));
}

TEST(NrrdGeometry, TwoDimensionalImageIsOneSlice)
{
    const TempDir dir;
    const LoadedVolume v =
        load(dir.write("v.nrrd", nrrd("type: uchar\ndimension: 2\nsizes: 3 2\nspacings: 2 3\nencoding: raw\n",
                                      bytes_of(ramp<std::uint8_t>(3, 2, 1)))));
    expect_ramp(v.grid, {3, 2, 1});
    expect_point(sample_position(v.grid, 1, 1, 1), {2, 3, 1});
}

TEST(NrrdGeometry, DegenerateIsRefused)
{
    const TempDir dir;
    const std::string start = "type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n", data(8, 'x');
    EXPECT_THAT(load_error(dir.write("zero.nrrd", nrrd(start + "spacings: 1 0 1\n", data))), HasSubstr("spacing"));
    EXPECT_THAT(load_error(dir.write("inf.nrrd", nrrd(start + "spacings: 1 inf 1\n", data))), HasSubstr("spacing"));
    EXPECT_THAT(load_error(dir.write("plane.nrrd",
                                     nrrd(start + "space: LPS\nspace directions: (1,0,0) (0,1,0) (1,1,0)\n", data))),
                HasSubstr("in one plane"));
}

TEST(NrrdFrames, TimeLastOrListFirstOrInBetween)
{
    const TempDir dir;
    const std::string data = bytes_of(ramp<std::uint16_t>(4, 3, 2, 5));
    std::vector<std::uint16_t> first, third;
    const auto all = ramp<std::uint16_t>(4, 3, 2, 5);
    for (std::size_t voxel = 0; voxel < 24; ++voxel)
        for (std::size_t f = 0; f < 5; ++f)
            first.push_back(all[f * 24 + voxel]);
    for (std::size_t k = 0; k < 2; ++k)
        for (std::size_t f = 0; f < 5; ++f)
            for (std::size_t p = 0; p < 12; ++p)
                third.push_back(all[f * 24 + k * 12 + p]);
    const std::string type = "type: ushort\nendian: little\ndimension: 4\n";
    const std::vector<std::filesystem::path> files{
        dir.write("last.nrrd", nrrd(type + "sizes: 4 3 2 5\nencoding: raw\nspacings: 1 1 1 0.1\n", data)),
        dir.write("kinds.nrrd",
                  nrrd(type + "sizes: 4 3 2 5\nencoding: raw\nkinds: domain domain domain list\nspace: LPS\n"
                              "space directions: (1,0,0) (0,1,0) (0,0,1) none\n",
                       data)),
        dir.write("packed.nrrd",
                  nrrd(type + "sizes: 4 3 2 5\nencoding: gzip\nkinds: space space space time\nspacings: 1 1 1 1\n",
                       deflated(data, Wrapping::gzip))),
        dir.write("first.nrrd",
                  nrrd(type + "sizes: 5 4 3 2\nencoding: raw\nkinds: list domain domain domain\nspace: LPS\n"
                              "space directions: none (1,0,0) (0,1,0) (0,0,1)\n",
                       bytes_of(first))),
        dir.write("third.nrrd",
                  nrrd(type + "sizes: 4 3 5 2\nencoding: raw\nkinds: domain domain time domain\nspacings: 1 1 1 1\n",
                       bytes_of(third))),
        dir.write("spacetime.nrrd",
                  nrrd(type + "sizes: 4 3 2 5\nencoding: raw\nspace: left-posterior-superior-time\n"
                              "space directions: (1,0,0,0) (0,1,0,0) (0,0,1,0) (0,0,0,0.1)\nspace origin: (0,0,0,0)\n",
                       data)),
        dir.write("skipped.nrrd",
                  nrrd(type + "sizes: 5 4 3 2\nencoding: raw\nbyte skip: 3\nkinds: list domain domain domain\n"
                              "spacings: nan 1 1 1\n",
                       "abc" + bytes_of(first)))};
    for (const auto& file : files)
        for (int frame : {0, 1, 4}) {
            SCOPED_TRACE(file.filename().string() + " frame " + std::to_string(frame));
            const LoadedVolume v = load(file, frame);
            EXPECT_EQ(v.frames, 5);
            EXPECT_EQ(v.grid.bytes(), 48U);
            expect_ramp(v.grid, {4, 3, 2}, 1000.0 * frame);
            expect_point(sample_position(v.grid, 3, 2, 1), {3, 2, 1});
        }
    for (int frame : {-1, 5})
        EXPECT_THAT(load_error(files[0], frame), HasSubstr("there are 5"));
}

TEST(NrrdFrames, ComponentsAreRefused)
{
    const TempDir dir;
    const std::string data(48, 'x');
    for (const char* kind : {"RGB-color", "3-vector", "vector", "3-color"})
        EXPECT_THAT(
            load_error(dir.write("v.nrrd",
                                 nrrd(std::string("type: uchar\ndimension: 4\nsizes: 3 4 2 2\nencoding: raw\nkinds: ") +
                                          kind + " domain domain domain\n",
                                      data))),
            HasSubstr("3 components per voxel"));
    EXPECT_THAT(
        load_error(dir.write("c.nrrd", nrrd("type: uchar\ndimension: 4\nsizes: 2 4 2 3\nencoding: raw\nkinds: complex "
                                            "domain domain domain\n",
                                            data))),
        HasSubstr("2 components per voxel"));
    const LoadedVolume one =
        load(dir.write("one.nrrd", nrrd("type: uchar\ndimension: 4\nsizes: 1 4 3 4\nencoding: raw\n"
                                        "kinds: vector domain domain domain\nspacings: nan 1 1 1\n",
                                        data)));
    EXPECT_TRUE((one.grid.size() == Vec3i{4, 3, 4}));
}

TEST(NrrdHostile, OneLineEach)
{
    const TempDir dir;
    const std::string ok = "type: short\ndimension: 3\nsizes: 4 4 4\nspacings: 1 1 1\nendian: little\n";
    std::string raw;
    for (std::uint32_t i = 0; i < 128; ++i)
        raw += char(i * 2654435761U >> 24); // not compressible
    std::string wrong_sum = deflated(raw, Wrapping::gzip);
    wrong_sum[wrong_sum.size() - 8] = char(wrong_sum[wrong_sum.size() - 8] ^ 1);
    const struct {
        const char* name;
        std::string bytes;
        const char* expected;
    } cases[] = {
        {"empty.nrrd", "", "empty"},
        {"garbage.nrrd", std::string(1000, '\x7f'), "not a readable NRRD"},
        {"magic.nrrd", "NRRD0004\n", "not a readable NRRD"},
        {"truncated.nrrd", nrrd(ok + "encoding: raw\n", raw.substr(0, 127)),
         "promises 128 bytes of voxels, the file holds 127"},
        {"truncated_gzip.nrrd", nrrd(ok + "encoding: gzip\n", deflated(raw, Wrapping::gzip).substr(0, 100)),
         "truncated"},
        {"checksum.nrrd", nrrd(ok + "encoding: gzip\n", wrong_sum), "incorrect data check"},
        {"short_gzip.nrrd", nrrd(ok + "encoding: gzip\n", deflated(raw.substr(1), Wrapping::gzip)), "truncated"},
        {"bad_gzip.nrrd", nrrd(ok + "encoding: gzip\n", raw), "damaged"},
        {"bad_ascii.nrrd", nrrd(ok + "encoding: ascii\n", "1 2 3"), "not a readable NRRD"},
        {"unknown.nrrd", nrrd(ok + "encoding: lzma\n", raw), "not a readable NRRD"},
        {"zero.nrrd", nrrd("type: short\ndimension: 3\nsizes: 4 0 4\nencoding: raw\nendian: little\n", raw),
         "not a readable NRRD"},
        {"negative.nrrd", nrrd("type: short\ndimension: 3\nsizes: 4 -4 4\nencoding: raw\nendian: little\n", raw), ""},
        {"huge.nrrd",
         nrrd("type: short\ndimension: 3\nsizes: 1048576 1048576 1048576\nencoding: raw\nendian: little\n", raw),
         "each side must be"},
        {"overflow.nrrd",
         nrrd("type: short\ndimension: 3\nsizes: 4294967296 4294967296 4294967296\nencoding: raw\nendian: little\n",
              raw),
         ""},
        {"frames.nrrd",
         nrrd("type: short\ndimension: 4\nsizes: 4 4 4 99999999999\nencoding: raw\nendian: little\n", raw), "frames"},
        {"many.nrrd", nrrd("type: short\ndimension: 3\nsizes: 8192 8192 8192\nencoding: raw\nendian: little\n", raw),
         "2^31"},
        {"lying.nrrd",
         nrrd("type: short\ndimension: 3\nsizes: 2000 1000 1000\nencoding: gzip\nendian: little\n",
              deflated(raw, Wrapping::gzip)),
         "promises 4000000000 bytes"},
        {"five.nrrd", nrrd("type: short\ndimension: 5\nsizes: 2 2 2 2 4\nencoding: raw\nendian: little\n", raw),
         "more than one axis"},
        {"one.nrrd", nrrd("type: short\ndimension: 1\nsizes: 64\nencoding: raw\nendian: little\n", raw), "need 2 or 3"},
        {"block.nrrd",
         nrrd("type: block\nblock size: 2\nendian: little\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n", raw),
         "not numbers"},
        {"missing.nhdr", nrrd(ok + "encoding: raw\ndata file: nowhere.raw\n", ""), "not a readable NRRD"},
        {"control.nhdr", nrrd(ok + "encoding: raw\ndata file: a\rb\x01.raw\n", ""), "not a readable NRRD"}};
    for (const auto& c : cases) {
        SCOPED_TRACE(c.name);
        EXPECT_THAT(load_error(dir.write(c.name, c.bytes)), HasSubstr(c.expected));
    }
}

} // namespace
} // namespace lumisweep::test
