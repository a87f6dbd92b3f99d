#include <cmath>

#include <gmock/gmock.h>

#include "volume_io/test_files.h"

namespace lumisweep::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A NIfTI-1 header with the fields that matter here, written in either byte order.
struct Nifti {
    std::int16_t dim[8] = {3, 5, 4, 3, 1, 1, 1, 1};
    std::int16_t datatype = 4, bitpix = 16;
    float pixdim[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    float scl_slope = 0, scl_inter = 0;
    std::int16_t qform_code = 1, sform_code = 0;
    float quatern[3] = {0, 0, 0}, qoffset[3] = {0, 0, 0};
    float srow[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    float vox_offset = 352;
    char xyzt_units = 2;
    std::int32_t sizeof_hdr = 348;
    const char* magic = "n+1";
    bool big_endian = false;

    template <class T>
    void put(std::string& bytes, std::size_t at, T value) const
    {
        char raw[sizeof(T)];
        std::memcpy(raw, &value, sizeof(T));
        if (big_endian)
            std::reverse(raw, raw + sizeof(T));
        bytes.replace(at, sizeof(T), raw, sizeof(T));
    }

    std::string bytes() const
    {
        std::string b(352, '\0');
        put(b, 0, sizeof_hdr);
        for (std::size_t i = 0; i < 8; ++i) {
            put(b, 40 + 2 * i, dim[i]);
            put(b, 76 + 4 * i, pixdim[i]);
        }
        put(b, 70, datatype);
        put(b, 72, bitpix);
        put(b, 108, vox_offset);
        put(b, 112, scl_slope);
        put(b, 116, scl_inter);
        b[123] = xyzt_units;
        put(b, 252, qform_code);
        put(b, 254, sform_code);
        for (std::size_t i = 0; i < 3; ++i) {
            put(b, 256 + 4 * i, quatern[i]);
            put(b, 268 + 4 * i, qoffset[i]);
            for (std::size_t j = 0; j < 4; ++j)
                put(b, 280 + 16 * i + 4 * j, srow[i][j]);
        }
        b.replace(344, 3, magic, 3);
        return b;
    }
};

TEST(Nifti, PlainPackedAndBigEndian)
{
    const TempDir dir;
    Nifti little, big;
    big.big_endian = true;
    const std::string a = little.bytes() + bytes_of(ramp<std::int16_t>(5, 4, 3));
    const std::vector<std::filesystem::path> files{
        dir.write("a.nii", a), dir.write("b.nii.gz", deflated(a, Wrapping::gzip)), dir.write("unpacked.nii.gz", a),
        dir.write("packed.nii", deflated(a, Wrapping::gzip)),
        dir.write("c.nii", big.bytes() + swapped_bytes_of(ramp<std::int16_t>(5, 4, 3)))};
    for (const auto& file : files) {
        SCOPED_TRACE(file.filename());
        const LoadedVolume v = load(file);
        EXPECT_EQ(v.format, "NIfTI");
        EXPECT_EQ(v.grid.type(), VoxelType::i16);
        EXPECT_THAT(v.warnings, IsEmpty());
        expect_ramp(v.grid, {5, 4, 3});
        EXPECT_EQ(inspect_volume(file).voxel_type, "int16");
    }
}

TEST(Nifti, ScaleIsAppliedOnceAndVoxelsKeepTheirType)
{
    const TempDir dir;
    Nifti n;
    n.scl_slope = 0.5F;
    n.scl_inter = -1024;
    const LoadedVolume v = load(dir.write("a.nii", n.bytes() + bytes_of(std::vector<std::int16_t>(60, 100))));
    EXPECT_EQ(v.grid.type(), VoxelType::i16);
    EXPECT_EQ(v.grid.value(0, 0, 0), -974.0);
    n.scl_slope = 0; // unscaled, whatever the intercept
    EXPECT_EQ(load(dir.write("b.nii", n.bytes() + bytes_of(std::vector<std::int16_t>(60, 100)))).grid.value(0, 0, 0),
              100.0);
    n.scl_slope = std::nanf("");
    EXPECT_EQ(load(dir.write("c.nii", n.bytes() + bytes_of(std::vector<std::int16_t>(60, 100)))).grid.value(0, 0, 0),
              100.0);
}

TEST(Nifti, NanIsEmptyAndCounted)
{
    const TempDir dir;
    Nifti n;
    n.datatype = 16;
    n.bitpix = 32;
    std::vector<float> values(60, 1.5F);
    values[7] = std::nanf("");
    values[8] = INFINITY;
    const LoadedVolume v = load(dir.write("a.nii.gz", deflated(n.bytes() + bytes_of(values), Wrapping::gzip)));
    EXPECT_EQ(v.non_finite, 2U);
    EXPECT_TRUE(std::isnan(v.grid.value(2, 1, 0)));
    EXPECT_EQ(v.grid.value(1, 1, 0), 1.5);
}

TEST(Nifti, QuaternionSformAndNeither)
{
    const TempDir dir;
    const std::string data = bytes_of(ramp<std::int16_t>(5, 4, 3));
    Nifti q;
    q.pixdim[0] = -1; // the third axis is mirrored
    q.pixdim[1] = 2;
    q.pixdim[2] = 3;
    q.pixdim[3] = 4;
    // A quarter turn about z: x of the file goes to y of the (RAS) world, y to -x.
    q.quatern[2] = std::sqrt(0.5F);
    q.qoffset[0] = 10;
    q.qoffset[1] = 20;
    q.qoffset[2] = 30;
    LoadedVolume v = load(dir.write("q.nii", q.bytes() + data));
    expect_point(sample_position(v.grid, 0, 0, 0), {-10, -20, 30}, 1e-5);
    expect_point(sample_position(v.grid, 1, 0, 0), {-10, -22, 30}, 1e-5);
    expect_point(sample_position(v.grid, 0, 1, 0), {-7, -20, 30}, 1e-5);
    expect_point(sample_position(v.grid, 0, 0, 1), {-10, -20, 26}, 1e-5);

    Nifti s;
    s.qform_code = 0;
    s.sform_code = 2;
    const float sheared[3][4] = {{2, 0, 0.5F, 1}, {0, 3, 0, 2}, {0, 0, 4, 3}}; // no orthonormal directions
    std::memcpy(s.srow, sheared, sizeof(sheared));
    v = load(dir.write("s.nii", s.bytes() + data));
    expect_point(sample_position(v.grid, 0, 0, 0), {-1, -2, 3}, 1e-6);
    expect_point(sample_position(v.grid, 1, 1, 1), {-3.5, -5, 7}, 1e-6);
    EXPECT_THAT(v.warnings, IsEmpty());

    // Both, and they differ: the qform, unless the sform is in scanner coordinates.
    Nifti both = q;
    both.sform_code = 2;
    std::memcpy(both.srow, sheared, sizeof(sheared));
    expect_point(sample_position(load(dir.write("b.nii", both.bytes() + data)).grid, 0, 0, 0), {-10, -20, 30}, 1e-5);
    both.sform_code = 1;
    expect_point(sample_position(load(dir.write("b.nii", both.bytes() + data)).grid, 0, 0, 0), {-1, -2, 3}, 1e-5);

    Nifti none;
    none.qform_code = 0;
    none.pixdim[1] = 2;
    v = load(dir.write("n.nii", none.bytes() + data));
    expect_point(sample_position(v.grid, 1, 1, 1), {-2, -1, 1}, 1e-6);
    ASSERT_EQ(v.warnings.size(), 1U);
    EXPECT_THAT(v.warnings[0], HasSubstr("no orientation"));

    Nifti metres = q;
    metres.xyzt_units = 1;
    expect_point(inspect_volume(dir.write("m.nii", metres.bytes() + data)).spacing, {2000, 3000, 4000}, 1e-2);
}

TEST(Nifti, Frames)
{
    const TempDir dir;
    Nifti n;
    n.dim[0] = 4;
    n.dim[4] = 6;
    const std::string bytes = n.bytes() + bytes_of(ramp<std::int16_t>(5, 4, 3, 6));
    for (const auto& file : {dir.write("t.nii", bytes), dir.write("t.nii.gz", deflated(bytes, Wrapping::gzip))}) {
        for (int frame : {0, 2, 5}) {
            const LoadedVolume v = load(file, frame);
            EXPECT_EQ(v.frames, 6);
            expect_ramp(v.grid, {5, 4, 3}, 1000 * frame);
        }
        EXPECT_THAT(load_error(file, 6), HasSubstr("there are 6"));
    }
}

TEST(Nifti, HostileGivesOneLineEach)
{
    const TempDir dir;
    const std::string data = bytes_of(ramp<std::int16_t>(5, 4, 3));
    const auto with = [&](auto&& change) {
        Nifti n;
        change(n);
        return n.bytes() + data;
    };
    const std::string ok = Nifti().bytes() + data;
    const struct {
        const char* name;
        std::string bytes;
        const char* expected;
    } cases[] = {{"empty.nii", "", "empty"},
                 {"garbage.nii", std::string(500, '\x41'), "not a NIfTI"},
                 {"garbage.nii.gz", std::string(500, '\x41'), "not a NIfTI"},
                 {"header.nii", ok.substr(0, 200), "not a NIfTI"},
                 {"truncated.nii", ok.substr(0, ok.size() - 1), "promises 120 bytes of voxels, the file holds 119"},
                 {"truncated.nii.gz", deflated(ok, Wrapping::gzip).substr(0, 120), ""},
                 {"short.nii.gz", deflated(ok.substr(0, ok.size() - 1), Wrapping::gzip), "truncated"},
                 {"nifti2.nii", with([](Nifti& n) { n.sizeof_hdr = 540; }), "NIfTI-2"},
                 {"pair.nii", with([](Nifti& n) { n.magic = "ni1"; }), "single-file"},
                 {"zero.nii", with([](Nifti& n) { n.dim[2] = 0; }), ""},
                 {"negative.nii", with([](Nifti& n) { n.dim[1] = -5; }), ""},
                 {"dims.nii", with([](Nifti& n) { n.dim[0] = 9; }), ""},
                 {"huge.nii", with([](Nifti& n) { n.dim[1] = n.dim[2] = n.dim[3] = 32767; }), "each side"},
                 {"lying.nii", with([](Nifti& n) { n.dim[1] = n.dim[2] = 8000; }), "promises"},
                 {"rgb.nii", with([](Nifti& n) {
                      n.datatype = 128;
                      n.bitpix = 24;
                  }),
                  "RGB24"},
                 {"complex.nii", with([](Nifti& n) {
                      n.datatype = 32;
                      n.bitpix = 64;
                  }),
                  "COMPLEX64"},
                 {"type.nii", with([](Nifti& n) { n.datatype = 77; }), ""},
                 {"vector.nii", with([](Nifti& n) {
                      n.dim[0] = 5;
                      n.dim[5] = 3;
                  }),
                  "components per voxel"},
                 {"spacing.nii", with([](Nifti& n) { n.pixdim[2] = std::nanf(""); }), ""},
                 {"singular.nii", with([](Nifti& n) {
                      n.qform_code = 0;
                      n.sform_code = 1;
                      n.srow[2][2] = 0;
                  }),
                  "spacing 0"},
                 {"offset.nii", with([](Nifti& n) { n.vox_offset = 1e9F; }), ""},
                 {"offset2.nii", with([](Nifti& n) { n.vox_offset = -1e30F; }), ""},
                 {"scale.nii", with([](Nifti& n) { n.qoffset[0] = INFINITY; }), ""}};
    for (const auto& c : cases) {
        SCOPED_TRACE(c.name);
        EXPECT_THAT(load_error(dir.write(c.name, c.bytes)), HasSubstr(c.expected));
    }
}

} // namespace
} // namespace lumisweep::test
