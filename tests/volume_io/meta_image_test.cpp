#include <gmock/gmock.h>

#include "volume_io/test_files.h"

namespace lumisweep::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string start =
    "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementSpacing = 1 1 1\nElementType = MET_SHORT\n"
    "BinaryData = True\nBinaryDataByteOrderMSB = False\n";

TEST(MetaImage, AttachedDetachedCompressedSwapped)
{
    const TempDir dir;
    const std::string raw = bytes_of(ramp<std::int16_t>(5, 4, 3));
    const std::string packed = deflated(raw, Wrapping::zlib);
    dir.write("sub/v.raw", raw);
    dir.write("v.zraw", packed);
    dir.write("v.skip", "12345" + raw);
    const std::vector<std::filesystem::path> files{
        dir.write("a.mha", start + "ElementDataFile = LOCAL\n" + raw),
        dir.write("b.mhd", start + "ElementDataFile = sub/v.raw\n"),
        dir.write("c.mhd", start + "ElementDataFile = " + (dir / "sub/v.raw").string() + "\n"),
        dir.write("d.mha", start + "CompressedData = True\nCompressedDataSize = " + std::to_string(packed.size()) +
                               "\nElementDataFile = LOCAL\n" + packed),
        dir.write("e.mhd", start + "CompressedData = True\nElementDataFile = v.zraw\n"),
        dir.write("f.mha", start + "ElementByteOrderMSB = True\nElementDataFile = LOCAL\n" +
                               swapped_bytes_of(ramp<std::int16_t>(5, 4, 3))),
        dir.write("g.mhd", start + "HeaderSize = 5\nElementDataFile = v.skip\n"),
        dir.write("h.mhd", start + "HeaderSize = -1\nElementDataFile = v.skip\n"),
        dir.write("i.mha", "NDims=3\r\nDimSize = 5 4 3\r\nElementSpacing = 1 1 1\r\nElementType = MET_SHORT\r\n"
                           "ElementDataFile = LOCAL\r\n" +
                               raw)};
    for (const auto& file : files) {
        SCOPED_TRACE(file.filename());
        const LoadedVolume v = load(file);
        EXPECT_EQ(v.format, "MetaImage");
        EXPECT_EQ(v.grid.type(), VoxelType::i16);
        EXPECT_THAT(v.warnings, IsEmpty());
        expect_ramp(v.grid, {5, 4, 3});
    }
}

TEST(MetaImage, GeometryScaleAndModality)
{
    const TempDir dir;
    const auto file = dir.write("v.mha", "NDims = 3\nDimSize = 5 4 3\nElementType = MET_UCHAR\nElementSpacing = 2 3 4\n"
                                         "TransformMatrix = 0 1 0 -0.8 0 0.6 0.6 0 0.8\nOffset = 10 20 30\n"
                                         "Modality = MET_MOD_CT\nElementToIntensityFunctionSlope = 0.5\n"
                                         "ElementToIntensityFunctionOffset = -100\nElementDataFile = LOCAL\n" +
                                             bytes_of(std::vector<std::uint8_t>(60, 50)));
    const LoadedVolume v = load(file);
    EXPECT_EQ(v.grid.type(), VoxelType::u8);
    EXPECT_EQ(v.grid.value(2, 2, 2), -75.0);
    EXPECT_EQ(v.modality, "CT");
    expect_point(sample_position(v.grid, 0, 0, 0), {10, 20, 30});
    expect_point(sample_position(v.grid, 1, 0, 0), {10, 22, 30});
    expect_point(sample_position(v.grid, 0, 1, 0), {10 - 2.4, 20, 30 + 1.8});
    expect_point(sample_position(v.grid, 0, 0, 1), {10 + 2.4, 20, 30 + 3.2});
}

TEST(MetaImage, FramesAndTwoDimensions)
{
    const TempDir dir;
    const auto file =
        dir.write("t.mha", "NDims = 4\nDimSize = 4 3 2 5\nElementType = MET_USHORT\nElementSpacing = 1 2 3 0.5\n"
                           "TransformMatrix = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\nOffset = 7 8 9 0\n"
                           "ElementDataFile = LOCAL\n" +
                               bytes_of(ramp<std::uint16_t>(4, 3, 2, 5)));
    for (int frame : {0, 3, 4}) {
        const LoadedVolume v = load(file, frame);
        EXPECT_EQ(v.frames, 5);
        expect_ramp(v.grid, {4, 3, 2}, 1000 * frame);
        expect_point(sample_position(v.grid, 1, 1, 1), {8, 10, 12});
    }
    EXPECT_THAT(load_error(file, 5), HasSubstr("there are 5"));
    const LoadedVolume flat =
        load(dir.write("f.mha", "NDims = 2\nDimSize = 4 3\nElementType = MET_UCHAR\nElementSpacing = 2 3\n"
                                "ElementDataFile = LOCAL\n" +
                                    bytes_of(ramp<std::uint8_t>(4, 3, 1))));
    expect_ramp(flat.grid, {4, 3, 1});
    expect_point(sample_position(flat.grid, 1, 1, 0), {2, 3, 0});
}

TEST(MetaImage, MissingSpacingIsAssumedAndSaid)
{
    const TempDir dir;
    const LoadedVolume v =
        load(dir.write("v.mha", "NDims = 3\nDimSize = 1 1 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\nab"));
    ASSERT_EQ(v.warnings.size(), 1U);
    EXPECT_THAT(v.warnings[0], HasSubstr("1 mm is assumed"));
}

TEST(MetaImage, HostileGivesOneLineEach)
{
    const TempDir dir;
    const std::string raw(120, 'x'), local = "ElementDataFile = LOCAL\n";
    const auto replaced = [&](const std::string& from, const std::string& to) {
        std::string s = start;
        s.replace(s.find(from), from.size(), to);
        return s + local + raw;
    };
    const struct {
        const char* name;
        std::string bytes;
        const char* expected;
    } cases[] = {
        {"empty.mha", "", "empty"},
        {"garbage.mha", std::string(100000, '\xff'), "not a MetaImage"},
        {"text.mha", "hello\nworld\n", "not a MetaImage"},
        {"endless.mha", std::string(200000, 'a') + " = b", "not a MetaImage"},
        {"no_data.mha", start, "ElementDataFile is missing"},
        {"truncated.mha", start + local + raw.substr(1), "promises 120 bytes of voxels, the file holds 119"},
        {"packed.mha", start + "CompressedData = True\n" + local + raw, "damaged"},
        {"short.mha", start + "CompressedData = True\n" + local + deflated(raw.substr(1), Wrapping::zlib), "truncated"},
        {"dims.mha", replaced("NDims = 3", "NDims = 100000"), "NDims"},
        {"dims0.mha", replaced("NDims = 3", "NDims = 0"), "NDims"},
        {"dimsx.mha", replaced("NDims = 3", "NDims = three"), "should be 1 numbers"},
        {"dimsize.mha", replaced("5 4 3", "5 4"), "should be 3 numbers"},
        {"zero.mha", replaced("5 4 3", "5 0 3"), "positive whole number"},
        {"negative.mha", replaced("5 4 3", "5 -4 3"), "positive whole number"},
        {"nan.mha", replaced("5 4 3", "5 nan 3"), "positive whole number"},
        {"huge.mha", replaced("5 4 3", "1048576 1048576 1048576"), "each side"},
        {"overflow.mha", replaced("5 4 3", "1e300 4 3"), "positive whole number"},
        {"type.mha", replaced("MET_SHORT", "MET_SHORT_ARRAY"), "ElementType"},
        {"spacing0.mha", replaced("1 1 1", "1 0 1"), "spacing 0"},
        {"spacingnan.mha", replaced("1 1 1", "1 nan 1"), "not finite"},
        {"matrix.mha", start + "TransformMatrix = 1 0 0 1 0 0 0 0 1\n" + local + raw, "in one plane"},
        {"channels.mha", start + "ElementNumberOfChannels = 3\n" + local + raw, "3 channels"},
        {"slope.mha", start + "ElementToIntensityFunctionSlope = 0\n" + local + raw, "slope 0"},
        {"ascii.mha", replaced("BinaryData = True", "BinaryData = False"), "as text"},
        {"list.mhd", start + "ElementDataFile = LIST\na.raw\n", "several files"},
        {"missing.mhd", start + "ElementDataFile = nowhere.raw\n", "promises"}};
    for (const auto& c : cases) {
        SCOPED_TRACE(c.name);
        if (std::string(c.name) == "missing.mhd") {
            // The message names the file that is missing.
            try {
                load(dir.write(c.name, c.bytes));
                ADD_FAILURE();
            } catch (const Error& e) {
                EXPECT_THAT(e.what(), HasSubstr("nowhere.raw: cannot be read"));
            }
            continue;
        }
        EXPECT_THAT(load_error(dir.write(c.name, c.bytes)), HasSubstr(c.expected));
    }
}

} // namespace
} // namespace lumisweep::test
