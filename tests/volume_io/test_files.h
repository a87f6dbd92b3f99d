// Files that the tests write themselves, byte by byte.
#pragma once

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <zlib.h>

#include "lumisweep/base/error.h"
#include "lumisweep/volume/io/load_volume.h"

namespace lumisweep::test {

/// A directory that goes away with the object.
class TempDir {
public:
    TempDir()
    {
        std::string name = (std::filesystem::temp_directory_path() / "lumisweep-test-XXXXXX").string();
        if (!mkdtemp(name.data()))
            throw std::runtime_error("no temporary directory");
        path_ = name;
    }
    ~TempDir()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TempDir(const TempDir&) = delete;
    TempDir& operator=(const TempDir&) = delete;

    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    const std::filesystem::path& path() const { return path_; }

    std::filesystem::path write(const std::string& name, const std::string& bytes) const
    {
        std::filesystem::create_directories((path_ / name).parent_path());
        std::ofstream(path_ / name, std::ios::binary) << bytes;
        return path_ / name;
    }

private:
    std::filesystem::path path_;
};

template <class T>
std::string bytes_of(const std::vector<T>& values)
{
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

template <class T>
std::string swapped_bytes_of(const std::vector<T>& values)
{
    std::string bytes = bytes_of(values);
    for (std::size_t i = 0; i < bytes.size(); i += sizeof(T))
        std::reverse(bytes.begin() + std::ptrdiff_t(i), bytes.begin() + std::ptrdiff_t(i + sizeof(T)));
    return bytes;
}

/// i + 10 j + 100 k + 1000 frame, x fastest, frame slowest.
template <class T>
std::vector<T> ramp(int nx, int ny, int nz, int frames = 1)
{
    std::vector<T> v;
    for (int f = 0; f < frames; ++f)
        for (int k = 0; k < nz; ++k)
            for (int j = 0; j < ny; ++j)
                for (int i = 0; i < nx; ++i)
                    v.push_back(static_cast<T>(i + 10 * j + 100 * k + 1000 * f));
    return v;
}

enum class Wrapping { zlib = 15, gzip = 15 + 16 };

inline std::string deflated(const std::string& bytes, Wrapping wrapping)
{
    z_stream stream{};
    deflateInit2(&stream, 6, Z_DEFLATED, static_cast<int>(wrapping), 8, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&stream, bytes.size()) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

inline LoadedVolume load(const std::filesystem::path& path, int frame = 0) { return load_volume({{path}, frame}); }

/// The message of the Error that loading gives; checks that it is one line that names the file and a mend.
inline std::string load_error(const std::filesystem::path& path, int frame = 0)
{
    try {
        load(path, frame);
    } catch (const Error& e) {
        const std::string message = e.what();
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
        EXPECT_NE(message.find(path.filename().string()), std::string::npos) << message;
        EXPECT_NE(message.find('('), std::string::npos) << "no mend: " << message;
        return message;
    }
    ADD_FAILURE() << path << " loads without an error";
    return {};
}

inline void expect_point(const Vec3d& got, const Vec3d& want, double tolerance = 1e-9)
{
    EXPECT_NEAR(got.x, want.x, tolerance);
    EXPECT_NEAR(got.y, want.y, tolerance);
    EXPECT_NEAR(got.z, want.z, tolerance);
}

/// World position of the sample of voxel (i, j, k).
inline Vec3d sample_position(const ScalarGrid& grid, double i, double j, double k)
{
    return grid.world_from_voxel().point({i + 0.5, j + 0.5, k + 0.5});
}

/// Expects the ramp of ramp() with `offset` added, everywhere.
inline void expect_ramp(const ScalarGrid& grid, Vec3i size, double offset = 0.0)
{
    ASSERT_TRUE(grid.size() == size) << grid.size().x << ' ' << grid.size().y << ' ' << grid.size().z;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i)
                ASSERT_DOUBLE_EQ(grid.value(i, j, k), i + 10 * j + 100 * k + offset) << i << ' ' << j << ' ' << k;
}

} // namespace lumisweep::test
