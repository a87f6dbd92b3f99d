// A folder for a test's files that goes away with it, and checks that many tests of readers share.
#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lumisweep/base/error.h"

namespace lumisweep {

class ScratchFolder {
public:
    ScratchFolder()
        : path_(std::filesystem::temp_directory_path() / ("lumisweep-image-" + std::to_string(std::random_device{}())))
    {
        std::filesystem::create_directories(path_);
    }
    ~ScratchFolder() { std::filesystem::remove_all(path_); }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    std::size_t count_files() const
    {
        const std::filesystem::directory_iterator files(path_);
        return static_cast<std::size_t>(std::distance(begin(files), end(files)));
    }

private:
    std::filesystem::path path_;
};

using Bytes = std::vector<std::byte>;

inline Bytes read_all(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    Bytes bytes(text.size());
    std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
    return bytes;
}

inline void write_all(const std::filesystem::path& path, const Bytes& bytes)
{
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

inline Bytes bytes_of(const std::string& text)
{
    Bytes bytes(text.size());
    std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
    return bytes;
}

/// Expects an Error of one line that names `name`.
inline void expect_one_line_error(const std::string& name, const std::function<void()>& action)
{
    try {
        action();
        ADD_FAILURE() << name << ": no error";
    } catch (const Error& e) {
        const std::string what = e.what();
        EXPECT_NE(what.find(name), std::string::npos) << what;
        EXPECT_EQ(what.find('\n'), std::string::npos) << what;
        EXPECT_GT(what.size(), name.size() + 10);
    }
}

/// Runs `read` on damaged copies of a sound file: each either fails with one line or gives an image, never anything
/// else.
inline void try_damaged_copies(const Bytes& sound, const std::function<void(const Bytes&)>& read)
{
    const auto survives = [&](const Bytes& bytes) {
        try {
            read(bytes);
        } catch (const Error& e) {
            EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
        }
    };
    std::mt19937 random(17);
    for (int i = 0; i < 400; ++i) {
        Bytes bytes = sound;
        for (unsigned k = 0; k <= random() % 4; ++k) {
            // Half of the damage in the header, where it does most.
            const std::size_t reach = random() % 2 ? bytes.size() : std::min<std::size_t>(bytes.size(), 400);
            bytes[random() % reach] = static_cast<std::byte>(random() % 3 == 0 ? 0xff : random() % 256);
        }
        survives(bytes);
    }
}

} // namespace lumisweep
