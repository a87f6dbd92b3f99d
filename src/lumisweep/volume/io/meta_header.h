// The text header of a MetaImage, checked as it is read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace lumisweep {

class MetaHeader {
public:
    /// Reads "Key = value" lines up to ElementDataFile. Throws Error for files without them.
    explicit MetaHeader(const std::filesystem::path& path);

    const std::string& where() const { return where_; }
    std::uint64_t bytes() const { return bytes_; } ///< of the header: local data follow there

    /// Empty when absent. Keys are compared without regard to case.
    std::string text(const std::string& key) const;
    bool flag(const std::string& key) const;
    /// Exactly `count` numbers, or none when the key is absent; throws Error for anything else.
    std::vector<double> numbers(const std::string& key, std::size_t count) const;
    /// Like numbers(), for whole numbers; `otherwise` when the key is absent.
    std::int64_t integer(const std::string& key, std::int64_t otherwise) const;

private:
    std::string where_;
    std::uint64_t bytes_ = 0;
    std::map<std::string, std::string> fields_;
};

} // namespace lumisweep
