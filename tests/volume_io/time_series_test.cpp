#include <sys/resource.h>
#include <unistd.h>

#include <gmock/gmock.h>

#include "lumisweep/volume/io/expand_files.h"
#include "volume_io/test_files.h"

namespace lumisweep::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string mha(int frame, int frames = 1, const std::string& size = "2 2 2")
{
    const std::string dims =
        frames > 1 ? "NDims = 4\nDimSize = " + size + " " + std::to_string(frames) + "\nElementSpacing = 1 1 1 1\n"
                   : "NDims = 3\nDimSize = " + size + "\nElementSpacing = 1 1 1\n";
    return dims + "ElementType = MET_USHORT\nElementDataFile = LOCAL\n" +
           bytes_of(ramp<std::uint16_t>(2, 2, 2, frame + frames)).substr(std::size_t(frame) * 16);
}

TEST(NaturalOrder, DigitsCountAsNumbers)
{
    const auto in_order = [](const char* a, const char* b) { return natural_less(a, b) && !natural_less(b, a); };
    EXPECT_TRUE(in_order("frame2", "frame10"));
    EXPECT_TRUE(in_order("frame2.nrrd", "frame2b.nrrd"));
    EXPECT_TRUE(in_order("a9/b10", "a10/b1"));
    EXPECT_TRUE(in_order("frame2", "frame02")); // equal but for zeros: shorter first
    EXPECT_TRUE(in_order("frame02", "frame3"));
    EXPECT_TRUE(in_order("1", "99999999999999999999999999"));
    EXPECT_TRUE(in_order("", "a"));
    EXPECT_TRUE(in_order("a", "b"));
    EXPECT_FALSE(natural_less("a1", "a1"));
}

TEST(ExpandFiles, GlobInNaturalOrder)
{
    const TempDir dir;
    for (const char* name : {"t10.mha", "t2.mha", "t1.mha", "u1.mha", "t3.txt"})
        dir.write(name, "x");
    EXPECT_THAT(expand_files((dir / "t*.mha").string()), ElementsAre(dir / "t1.mha", dir / "t2.mha", dir / "t10.mha"));
    EXPECT_THAT(expand_files((dir / "[tu]1.mha").string()), ElementsAre(dir / "t1.mha", dir / "u1.mha"));
    EXPECT_THAT(expand_files((dir / "t?.mha").string()), ElementsAre(dir / "t1.mha", dir / "t2.mha"));
    dir.write("t[1].mha", "x"); // a name with brackets is itself, not a pattern
    EXPECT_THAT(expand_files((dir / "t[1].mha").string()), ElementsAre(dir / "t[1].mha"));
    try {
        expand_files((dir / "nothing*").string());
        FAIL();
    } catch (const Error& e) {
        EXPECT_THAT(e.what(), AllOf(HasSubstr("nothing*"), HasSubstr("no file matches")));
    }
}

TEST(TimeSeries, FramesOfAllFilesCountOn)
{
    const TempDir dir;
    const VolumeRequest request{{dir.write("a.mha", mha(0)), dir.write("b.mha", mha(1, 3)), dir.write("c.mha", mha(4))},
                                0};
    for (int frame = 0; frame < 5; ++frame) {
        VolumeRequest one = request;
        one.frame = frame;
        const LoadedVolume v = load_volume(one);
        EXPECT_EQ(v.frames, 5);
        expect_ramp(v.grid, {2, 2, 2}, 1000 * frame);
    }
    VolumeRequest beyond = request;
    beyond.frame = 5;
    try {
        load_volume(beyond);
        FAIL();
    } catch (const Error& e) {
        EXPECT_THAT(e.what(), AllOf(HasSubstr("frame 5"), HasSubstr("there are 5")));
    }
}

TEST(TimeSeries, FramesOfDifferentSizeAreRefused)
{
    const TempDir dir;
    const VolumeRequest request{{dir.write("a.mha", mha(0)), dir.write("b.mha", mha(0, 1, "4 2 1"))}, 0};
    try {
        load_volume(request);
        FAIL();
    } catch (const Error& e) {
        EXPECT_THAT(e.what(), AllOf(HasSubstr("b.mha"), HasSubstr("4 x 2 x 1"), HasSubstr("2 x 2 x 2")));
    }
}

TEST(LoadVolume, WhatIsNoVolumeFile)
{
    const TempDir dir;
    EXPECT_THROW(load_volume({}), Error);
    EXPECT_THAT(load_error(dir / "absent.nrrd"), HasSubstr("no such file"));
    EXPECT_THAT(load_error(dir.write("a.xyz", "hello")), HasSubstr("unknown volume format"));
    EXPECT_THAT(load_error(dir.write("new\nline.xyz", "hello").parent_path() / "new line.xyz"),
                HasSubstr("no such file"));
    try {
        load(dir / "new\nline.xyz");
        FAIL();
    } catch (const Error& e) {
        EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    }
    if (geteuid() != 0) { // root may read everything
        const auto file = dir.write("secret.mha", mha(0));
        std::filesystem::permissions(file, std::filesystem::perms::none);
        EXPECT_THAT(load_error(file), HasSubstr("permissions"));
    }
}

TEST(LoadVolume, MemoryIsRefusedBeforeItIsTaken)
{
    const TempDir dir;
    // A sparse file: as large as its header says, without taking the disk.
    const auto file =
        dir.write("v.mha", "NDims = 3\nDimSize = 1024 1024 1024\nElementSpacing = 1 1 1\nElementType = MET_FLOAT\n"
                           "ElementDataFile = LOCAL\n");
    std::filesystem::resize_file(file, (std::uint64_t(4) << 30) + 1000);
    EXPECT_EQ(inspect_volume(file).bytes_needed, std::uint64_t(4) << 30);

    std::uint64_t used_pages = 0;
    std::ifstream("/proc/self/statm") >> used_pages;
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
    rlimit tight = before;
    tight.rlim_cur = used_pages * std::uint64_t(sysconf(_SC_PAGESIZE)) + (std::uint64_t(1) << 30);
    ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);
    const std::string message = load_error(file);
    setrlimit(RLIMIT_AS, &before);
    EXPECT_THAT(message, AllOf(HasSubstr("needs 4.0 GiB of memory"), HasSubstr("crop or downsample")));
}

} // namespace
} // namespace lumisweep::test
