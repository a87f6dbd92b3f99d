#include <gmock/gmock.h>

#include "volume_io/dicom_writer.h"

namespace lumisweep::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// File names run against the positions, so that sorting by name would be wrong.
std::string name_of_slice(int k) { return "IM" + std::to_string(99 - k); }

void write_series(const TempDir& dir, const std::vector<double>& z, const std::string& folder = "s")
{
    for (int k = 0; k < int(z.size()); ++k)
        dir.write(folder + "/" + name_of_slice(k), ct_slice(k, z[std::size_t(k)]).bytes());
}

TEST(Dicom, SeriesIsSortedByPosition)
{
    const TempDir dir;
    write_series(dir, {-3, -0.5, 2, 4.5});
    const LoadedVolume v = load(dir / "s");
    EXPECT_EQ(v.format, "DICOM");
    EXPECT_EQ(v.modality, "CT");
    EXPECT_EQ(v.grid.type(), VoxelType::i16);
    EXPECT_THAT(v.warnings, IsEmpty());
    expect_ramp(v.grid, {5, 4, 4});
    expect_point(sample_position(v.grid, 0, 0, 0), {0, 0, -3});
    expect_point(sample_position(v.grid, 1, 1, 1), {1, 1, -0.5});
    const VolumeHeader h = inspect_volume(dir / "s");
    expect_point(h.spacing, {1, 1, 2.5});
    EXPECT_EQ(h.modality, "CT");
}

TEST(Dicom, ObliqueAnisotropicPlane)
{
    const TempDir dir;
    // Row direction +y, column direction +z, so the normal is +x; between rows 3 mm, between columns 2 mm.
    for (int k = 0; k < 3; ++k) {
        DicomFile f = ct_slice(k, 0);
        f.orientation = "0\\1\\0\\0\\0\\1";
        f.spacing = "3\\2"; // rows apart \ columns apart
        f.position = std::to_string(10 + 5 * k) + "\\20\\30";
        dir.write("s/" + name_of_slice(k), f.bytes());
    }
    const LoadedVolume v = load(dir / "s");
    expect_ramp(v.grid, {5, 4, 3});
    expect_point(sample_position(v.grid, 0, 0, 0), {10, 20, 30});
    expect_point(sample_position(v.grid, 1, 0, 0), {10, 22, 30});
    expect_point(sample_position(v.grid, 0, 1, 0), {10, 20, 33});
    expect_point(sample_position(v.grid, 0, 0, 1), {15, 20, 30});
}

TEST(Dicom, RescaleIsAppliedOnceAndVoxelsStaySmall)
{
    const TempDir dir;
    for (int k = 0; k < 2; ++k) {
        DicomFile f = ct_slice(k, k);
        f.is_signed = 0;
        f.stored = 12;
        f.slope = "2";
        f.intercept = "-1024";
        dir.write("s/" + name_of_slice(k), f.bytes());
    }
    const LoadedVolume v = load(dir / "s");
    EXPECT_EQ(v.grid.type(), VoxelType::u16);
    EXPECT_EQ(v.grid.value(3, 2, 1), 2 * 123 - 1024);
}

TEST(Dicom, SignedTwelveBitsAreExtended)
{
    const TempDir dir;
    DicomFile f;
    f.stored = 12;
    f.pixels = bytes_of(std::vector<std::uint16_t>(20, 0x0fff)); // -1 in 12 bits
    const LoadedVolume v = load(dir.write("a.dcm", f.bytes()));
    EXPECT_EQ(v.grid.value(0, 0, 0), -1.0);
}

TEST(Dicom, SlopesThatDifferBySliceGiveFloats)
{
    const TempDir dir;
    for (int k = 0; k < 3; ++k) {
        DicomFile f = ct_slice(k, k);
        f.modality = "PT";
        f.slope = std::to_string(1 + k) + ".5";
        f.intercept = "0";
        dir.write("s/" + name_of_slice(k), f.bytes());
    }
    const LoadedVolume v = load(dir / "s");
    EXPECT_EQ(v.grid.type(), VoxelType::f32);
    for (int k = 0; k < 3; ++k)
        EXPECT_FLOAT_EQ(float(v.grid.value(1, 1, k)), float((11 + 100 * k) * (1.5 + k)));
    EXPECT_THAT(v.warnings, Contains(HasSubstr("differ in pixel type or rescale slope")));
}

TEST(Dicom, IrregularGapsAreResampled)
{
    const TempDir dir;
    const std::vector<double> z{0, 1.9, 4, 6}; // gaps 1.9, 2.1, 2
    write_series(dir, z);
    const LoadedVolume v = load(dir / "s");
    ASSERT_EQ(v.grid.size().z, 4);
    EXPECT_THAT(v.warnings,
                Contains(HasSubstr("irregular slice gaps of 1.9 to 2.1 mm; resampled linearly to 4 slices, 2 mm")));
    // At z = 2: between slice 1 (100) and slice 2 (200).
    EXPECT_DOUBLE_EQ(v.grid.value(0, 0, 1), std::nearbyint(100 + 100 * 0.1 / 2.1));
    EXPECT_DOUBLE_EQ(v.grid.value(0, 0, 2), 200);
    EXPECT_DOUBLE_EQ(v.grid.value(0, 0, 3), 300);
    expect_point(sample_position(v.grid, 0, 0, 1), {0, 0, 2});

    write_series(dir, {0, 2.001, 4, 6}, "rounded"); // within 1 %
    EXPECT_THAT(load(dir / "rounded").warnings, IsEmpty());
}

TEST(Dicom, MissingSlicesAreFilledWithAStrongWarning)
{
    const TempDir dir;
    write_series(dir, {0, 1, 2, 5, 6});
    const LoadedVolume v = load(dir / "s");
    ASSERT_EQ(v.grid.size().z, 7);
    EXPECT_THAT(v.warnings, Contains(HasSubstr("MISSING in 1 places")));
    EXPECT_DOUBLE_EQ(v.grid.value(0, 0, 2), 200);
    EXPECT_DOUBLE_EQ(v.grid.value(0, 0, 3), 233); // 200 + 100/3
    EXPECT_DOUBLE_EQ(v.grid.value(0, 0, 6), 400);
}

TEST(Dicom, RepeatedPositionsKeepTheFirst)
{
    const TempDir dir;
    write_series(dir, {0, 1, 2});
    DicomFile twice = ct_slice(9, 1);
    dir.write("s/ZZ", twice.bytes());
    const LoadedVolume v = load(dir / "s");
    expect_ramp(v.grid, {5, 4, 3});
    EXPECT_THAT(v.warnings, Contains(HasSubstr("1 slices repeat a position")));
}

TEST(Dicom, RepeatedPositionsKeepTheLowestNumberWhateverTheFileNames)
{
    const TempDir dir;
    for (int k = 0; k < 3; ++k) {
        dir.write("s/later" + std::to_string(k), ct_slice(k, k).bytes());
        DicomFile second_moment = ct_slice(k + 3, k);
        dir.write((k == 1 ? "s/earlier" : "s/much_later") + std::to_string(k), second_moment.bytes());
    }
    expect_ramp(load(dir / "s").grid, {5, 4, 3});
}

TEST(Dicom, PaddingIsNoWallAroundThePatient)
{
    const TempDir dir;
    DicomFile f = ct_slice(0, 0);
    f.is_signed = 0;
    f.padding = 63536;
    f.intercept = "-1024";
    f.pixels.clear();
    for (int i = 0; i < 20; ++i)
        f.pixels += le16(i < 5 ? 63536 : 24 + 10U * unsigned(i));
    const LoadedVolume high = load(dir.write("high.dcm", f.bytes()));
    EXPECT_DOUBLE_EQ(high.grid.value(0, 0, 0), 24 + 50 - 1024); // the lowest scanned value
    EXPECT_DOUBLE_EQ(high.grid.value(4, 3, 0), 24 + 190 - 1024);

    f.padding = 24 + 100; // in the midst of real values: taken for one
    EXPECT_DOUBLE_EQ(load(dir.write("midst.dcm", f.bytes())).grid.value(0, 2, 0), 24 + 100 - 1024);

    f.is_signed = 1;
    f.padding = 65536 - 2000;
    const LoadedVolume low = load(dir.write("low.dcm", f.bytes()));
    EXPECT_DOUBLE_EQ(low.grid.value(0, 0, 0), -2000 - 1024); // below all others already: as it is
    EXPECT_DOUBLE_EQ(low.grid.value(4, 3, 0), 24 + 190 - 1024);
}

TEST(Dicom, GantryTiltKeepsTheShearExactly)
{
    const TempDir dir;
    for (int k = 0; k < 4; ++k) {
        DicomFile f = ct_slice(k, 0);
        f.position = "0\\" + std::to_string(0.5 * k) + "\\" + std::to_string(2 * k);
        dir.write("s/" + name_of_slice(k), f.bytes());
    }
    const LoadedVolume v = load(dir / "s");
    expect_ramp(v.grid, {5, 4, 4});
    for (int k = 0; k < 4; ++k)
        expect_point(sample_position(v.grid, 1, 1, k), {1, 1 + 0.5 * k, 2.0 * k});
    ASSERT_EQ(v.warnings.size(), 1U);
    EXPECT_THAT(v.warnings[0], HasSubstr("gantry tilt of 14 degrees"));
}

TEST(Dicom, LargestSeriesWinsAndOthersAreNamed)
{
    const TempDir dir;
    write_series(dir, {0, 1, 2});
    for (int k = 0; k < 2; ++k) {
        DicomFile f = ct_slice(k, k);
        f.series = "9.8.7";
        dir.write("s/other" + std::to_string(k), f.bytes());
    }
    DicomFile localizer = ct_slice(0, 0);
    localizer.orientation = "0\\1\\0\\0\\0\\1";
    dir.write("s/localizer", localizer.bytes());
    dir.write("s/notes.txt", "no DICOM");
    dir.write("s/sub/ignored", "not looked at");
    const LoadedVolume v = load(dir / "s");
    expect_ramp(v.grid, {5, 4, 3});
    EXPECT_THAT(v.warnings, Contains(HasSubstr("9.8.7 (2 slices of 5 x 4)")));
    EXPECT_THAT(v.warnings, Contains(HasSubstr("same series in another size or orientation")));
    EXPECT_THAT(v.warnings, Contains(HasSubstr("1 files are no readable DICOM images")));
}

TEST(Dicom, WithoutPositionsByNumber)
{
    const TempDir dir;
    for (int k = 0; k < 3; ++k) {
        DicomFile f = ct_slice(k, 0);
        f.position.reset();
        f.thickness = "2.5";
        dir.write("s/" + name_of_slice(k), f.bytes());
    }
    const LoadedVolume v = load(dir / "s");
    expect_ramp(v.grid, {5, 4, 3});
    expect_point(sample_position(v.grid, 0, 0, 1), {0, 0, 2.5});
    EXPECT_THAT(v.warnings, Contains(HasSubstr("stacked by number, 2.5 mm apart")));
}

TEST(Dicom, SingleFileIsOneSlice)
{
    const TempDir dir;
    DicomFile f = ct_slice(0, 7);
    f.thickness = "3";
    const LoadedVolume v = load(dir.write("one", f.bytes())); // recognised by its content
    expect_ramp(v.grid, {5, 4, 1});
    expect_point(sample_position(v.grid, 0, 0, 0), {0, 0, 7});
    expect_point(sample_position(v.grid, 0, 0, 1), {0, 0, 10});
}

TEST(Dicom, EnhancedMultiFrameIsSortedByItsFramePositions)
{
    const TempDir dir;
    DicomFile f;
    f.sop_class = "1.2.840.10008.5.1.4.1.1.2.1";
    f.position.reset();
    f.orientation.clear();
    f.spacing.clear();
    f.frames = "3";
    const std::string shared =
        element(0x20, 0x9116, "SQ", item(element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0"))) +
        element(0x28, 0x9110, "SQ", item(element(0x18, 0x50, "DS", "2") + element(0x28, 0x30, "DS", "1.5\\1")));
    std::string per_frame;
    for (int k : {2, 1, 0}) { // stored from the top down
        per_frame +=
            item(element(0x20, 0x9113, "SQ", item(element(0x20, 0x32, "DS", "0\\0\\" + std::to_string(2 * k)))));
        f.pixels += ct_slice(k, 0).pixels;
    }
    f.functional_groups = element(0x5200, 0x9229, "SQ", item(shared)) + element(0x5200, 0x9230, "SQ", per_frame);
    dir.write("s/enhanced", f.bytes());
    const LoadedVolume v = load(dir / "s");
    expect_ramp(v.grid, {5, 4, 3});
    expect_point(sample_position(v.grid, 1, 1, 1), {1, 1.5, 2});
}

TEST(Dicom, MissingOrUnreadableSpacingIsAssumedAndSaid)
{
    const TempDir dir;
    for (const char* spacing : {"", "nan\\1", "abc", "1\\1\\1"}) {
        DicomFile f = ct_slice(0, 0);
        f.spacing = spacing;
        EXPECT_THAT(load(dir.write("a.dcm", f.bytes())).warnings, Contains(HasSubstr("1 mm is assumed")));
    }
}

TEST(Dicom, HostileGivesOneLineEach)
{
    const TempDir dir;
    std::filesystem::create_directories(dir / "nothing");
    EXPECT_THAT(load_error(dir / "nothing"), HasSubstr("no DICOM images"));
    dir.write("text/readme", "hello");
    EXPECT_THAT(load_error(dir / "text"), HasSubstr("no DICOM images"));

    const auto with = [](auto&& change) {
        DicomFile f = ct_slice(0, 0);
        change(f);
        return f.bytes();
    };
    const std::string ok = ct_slice(0, 0).bytes();
    const struct {
        const char* name;
        std::string bytes;
        const char* expected;
    } cases[] = {{"empty.dcm", "", "empty"},
                 {"garbage.dcm", std::string(400, '\x33'), "not a readable DICOM"},
                 {"header.dcm", ok.substr(0, 300), ""},
                 {"truncated.dcm", ok.substr(0, ok.size() - 1), ""},
                 {"half.dcm", ok.substr(0, ok.size() - 20), ""},
                 {"rgb.dcm", with([](DicomFile& f) {
                      f.samples = 3;
                      f.bits = f.stored = 8;
                      f.is_signed = 0;
                  }),
                  "3 samples"},
                 {"rows.dcm", with([](DicomFile& f) { f.rows = 0; }), ""},
                 {"lying.dcm", with([](DicomFile& f) { f.rows = f.columns = 8000; }), ""},
                 {"wide.dcm", with([](DicomFile& f) { f.columns = 60000; }), "each side"},
                 {"bits.dcm", with([](DicomFile& f) { f.bits = 77; }), ""},
                 {"stored.dcm", with([](DicomFile& f) { f.stored = 40; }), ""},
                 {"slope.dcm", with([](DicomFile& f) {
                      f.slope = "0";
                      f.intercept = "0";
                  }),
                  ""},
                 {"spacing.dcm", with([](DicomFile& f) { f.spacing = "0\\1"; }), ""},
                 {"direction.dcm", with([](DicomFile& f) { f.orientation = "1\\0\\0\\1\\0\\0"; }), ""},
                 {"frames.dcm", with([](DicomFile& f) { f.frames = "2000000000"; }), ""}};
    for (const auto& c : cases) {
        SCOPED_TRACE(c.name);
        EXPECT_THAT(load_error(dir.write(c.name, c.bytes)), HasSubstr(c.expected));
    }
}

} // namespace
} // namespace lumisweep::test
