// Typed, checked access to one JSON object: every error names the key's path.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "lumisweep/math/vec.h"

namespace lumisweep {

/// Where a value stands, for messages: "scene.json: camera.up".
struct JsonPlace {
    std::string file;
    std::string path; ///< empty for the whole text

    JsonPlace at(std::string_view key) const;
    JsonPlace at(std::size_t index) const;
    std::string text() const;
};

enum class Ends { closed, open_low, open };

/// The numbers from low to high; `ends` says whether they are among them.
struct NumberRange {
    double low, high;
    Ends ends = Ends::closed;

    bool contains(double value) const;
    std::string text() const;
};

double read_number(const nlohmann::ordered_json& value, const JsonPlace& place, const NumberRange& range);
Vec3d read_vector(const nlohmann::ordered_json& value, const JsonPlace& place, const NumberRange& range);
const std::string& read_string(const nlohmann::ordered_json& value, const JsonPlace& place);
/// A whole number (2.0 counts) in [low, high].
std::uint64_t read_whole(const nlohmann::ordered_json& value, const JsonPlace& place, std::uint64_t low,
                         std::uint64_t high);

/// The candidate nearest to `word` by edit distance, when near enough to be what was meant; empty otherwise.
std::string nearest_word(std::string_view word, std::span<const std::string_view> candidates);

class ObjectReader {
public:
    /// Throws Error unless `value` is an object whose keys are all among `known`; suggests the nearest one.
    ObjectReader(const nlohmann::ordered_json& value, JsonPlace place, std::initializer_list<std::string_view> known);

    const JsonPlace& place() const { return place_; }
    JsonPlace place(std::string_view key) const { return place_.at(key); }
    /// nullptr when absent.
    const nlohmann::ordered_json* find(std::string_view key) const;
    const nlohmann::ordered_json& required(std::string_view key) const;
    /// Throws Error when more than one of the keys is there.
    void at_most_one(std::initializer_list<std::string_view> keys) const;

    // Absent keys leave `target` as it is.
    void number(std::string_view key, double& target, const NumberRange& range) const;
    void number(std::string_view key, std::optional<double>& target, const NumberRange& range) const;
    void whole(std::string_view key, int& target, int low, int high) const;
    void vector(std::string_view key, Vec3d& target, const NumberRange& range) const;
    void vector(std::string_view key, std::optional<Vec3d>& target, const NumberRange& range) const;
    void boolean(std::string_view key, bool& target) const;

    /// Index of the string in `names`; absent: nothing. Throws Error listing them for any other.
    std::optional<std::size_t> choice(std::string_view key, std::span<const std::string_view> names) const;

private:
    const nlohmann::ordered_json& value_;
    JsonPlace place_;
};

} // namespace lumisweep
