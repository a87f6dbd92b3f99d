#include "lumisweep/base/memory.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include "lumisweep/base/control_group.h"
#include "lumisweep/base/error.h"

namespace lumisweep {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr std::uint64_t mebibyte = std::uint64_t(1) << 20;

/// A copy of the kernel's control group files.
class FakeGroups {
public:
    FakeGroups()
    {
        std::string name = (fs::temp_directory_path() / "lumisweep-cgroup-XXXXXX").string();
        if (!mkdtemp(name.data()))
            throw std::runtime_error("no temporary directory");
        root_ = name;
    }
    ~FakeGroups()
    {
        std::error_code ignored;
        fs::remove_all(root_, ignored);
    }
    FakeGroups(const FakeGroups&) = delete;
    FakeGroups& operator=(const FakeGroups&) = delete;

    void write(const std::string& name, const std::string& text) const
    {
        fs::create_directories((root_ / name).parent_path());
        std::ofstream(root_ / name) << text;
    }
    std::uint64_t left() const { return control_group_memory_left(root_ / "membership", root_ / "mount"); }

private:
    fs::path root_;
};

TEST(ControlGroup, NoneMeansNoLimit)
{
    const FakeGroups groups;
    EXPECT_EQ(groups.left(), std::numeric_limits<std::uint64_t>::max());
    groups.write("membership", "0::/a\n");
    groups.write("mount/a/memory.max", "max\n");
    groups.write("mount/a/memory.current", "1000\n");
    EXPECT_EQ(groups.left(), std::numeric_limits<std::uint64_t>::max());
}

TEST(ControlGroup, VersionTwoTakesTheTightestAncestor)
{
    const FakeGroups groups;
    groups.write("membership", "0::/a/b\n");
    groups.write("mount/a/memory.max", "5000\n");
    groups.write("mount/a/memory.current", "3000\n");
    groups.write("mount/a/b/memory.max", "10000\n");
    groups.write("mount/a/b/memory.current", "1000\n");
    EXPECT_EQ(groups.left(), 2000U);
    groups.write("mount/a/memory.stat", "anon 100\ninactive_file 700\nslab 3\n"); // can be dropped
    EXPECT_EQ(groups.left(), 2700U);
    groups.write("mount/a/memory.current", "9000\n"); // above its limit
    EXPECT_EQ(groups.left(), 0U);
}

TEST(ControlGroup, InsideAContainerTheMountsRootCounts)
{
    const FakeGroups groups;
    groups.write("membership", "0::/system.slice/of-the-host\n");
    groups.write("mount/memory.max", "4096\n");
    groups.write("mount/memory.current", "96\n");
    EXPECT_EQ(groups.left(), 4000U);
}

TEST(ControlGroup, VersionOne)
{
    const FakeGroups groups;
    groups.write("membership", "5:cpu,cpuacct:/x\n4:memory:/job\n1:name=systemd:/y\n");
    groups.write("mount/memory/job/memory.limit_in_bytes", "8000\n");
    groups.write("mount/memory/job/memory.usage_in_bytes", "5000\n");
    groups.write("mount/memory/job/memory.stat", "cache 5\ntotal_inactive_file 1000\n");
    EXPECT_EQ(groups.left(), 4000U);
}

TEST(Memory, AvailableIsBelowTheMachinesMemory)
{
    const std::uint64_t pages = std::uint64_t(sysconf(_SC_PHYS_PAGES)), page = std::uint64_t(sysconf(_SC_PAGESIZE));
    EXPECT_GT(available_memory(), mebibyte);
    EXPECT_LE(available_memory(), pages * page);
}

TEST(Memory, AddressSpaceLimitIsHonoured)
{
    std::uint64_t used_pages = 0;
    std::ifstream("/proc/self/statm") >> used_pages;
    const std::uint64_t used = used_pages * std::uint64_t(sysconf(_SC_PAGESIZE));
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
    rlimit tight = before;
    tight.rlim_cur = used + 64 * mebibyte;
    ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);
    const std::uint64_t available = available_memory();
    setrlimit(RLIMIT_AS, &before);
    EXPECT_LE(available, 64 * mebibyte);
    EXPECT_GT(available, 32 * mebibyte);
}

TEST(Memory, RequireNamesWhatIsNeededAndTheMend)
{
    EXPECT_NO_THROW(require_memory(mebibyte, "volume.nrrd", "crop it"));
    try {
        require_memory(std::uint64_t(1) << 60, "volume.nrrd", "crop it");
        FAIL();
    } catch (const Error& e) {
        EXPECT_THAT(e.what(), AllOf(HasSubstr("volume.nrrd: needs 1.0 EiB"), HasSubstr("(crop it)")));
    }
    // A reserve of 5 % stays: everything that is available is too much.
    EXPECT_THROW(require_memory(available_memory(), "volume.nrrd", "crop it"), Error);
}

TEST(Memory, PeakGrowsWithWhatIsTouched)
{
    const std::uint64_t before = peak_resident_memory();
    ASSERT_GT(before, 0U);
    std::vector<char> touched(before + 64 * mebibyte, 1);
    EXPECT_EQ(touched.back(), 1);
    EXPECT_GE(peak_resident_memory(), before + 32 * mebibyte);
}

TEST(Memory, FormatBytes)
{
    EXPECT_EQ(format_bytes(0), "0 bytes");
    EXPECT_EQ(format_bytes(1023), "1023 bytes");
    EXPECT_EQ(format_bytes(1024), "1.0 KiB");
    EXPECT_EQ(format_bytes(3 * mebibyte / 2), "1.5 MiB");
    EXPECT_EQ(format_bytes(1024 * mebibyte - 1), "1.0 GiB");
    EXPECT_EQ(format_bytes(std::numeric_limits<std::uint64_t>::max()), "16.0 EiB");
}

} // namespace
} // namespace lumisweep
