// Strict JSON with comments: what scene files, transfer function files and checkpoint headers are parsed with.
// Internal to the library's scene layer: public headers do not show nlohmann's types.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace lumisweep {

inline constexpr std::size_t max_json_bytes = std::size_t{16} << 20;
inline constexpr int max_json_depth = 32;

/// Parses one JSON value; comments (// and /* */) are allowed. `name` begins every error message. Throws Error with
/// line and column for syntax errors, with the key for duplicate keys, and for nesting deeper than max_json_depth.
nlohmann::ordered_json parse_json(std::string_view text, const std::string& name);

/// Reads a whole text file of at most max_json_bytes. Throws Error when it is missing, a directory, unreadable or
/// larger.
std::string read_text_file(const std::filesystem::path& file);

/// `text` on one line of at most `limit` bytes, for messages: control characters and bytes outside ASCII become '?'.
std::string printable(std::string_view text, std::size_t limit = 120);

} // namespace lumisweep
