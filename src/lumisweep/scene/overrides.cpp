#include "lumisweep/scene/overrides.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "lumisweep/base/error.h"
#include "lumisweep/scene/json_text.h"

namespace lumisweep {

namespace {

using nlohmann::ordered_json;

struct ExclusiveKeys {
    std::string_view section;
    std::array<std::string_view, 3> keys;
};

constexpr std::array<ExclusiveKeys, 4> exclusive_keys{{
    {"volume", {"file", "files", ""}},
    {"transfer_function", {"points", "preset", ""}},
    {"environment", {"file", "radiance", "sky"}},
    {"render", {"samples", "time", "noise"}},
}};

std::vector<std::string> split_path(const SceneOverride& override)
{
    std::vector<std::string> keys(1);
    for (const char c : override.key_path) {
        if (c == '.')
            keys.emplace_back();
        else
            keys.back() += c;
    }
    require(std::none_of(keys.begin(), keys.end(), [](const std::string& key) { return key.empty(); }),
            "--set {}: an empty key (write KEY.PATH=VALUE, as in render.samples=16)", printable(override.key_path));
    require(keys.size() <= static_cast<std::size_t>(max_json_depth), "--set {}: deeper than {} keys",
            printable(override.key_path), max_json_depth);
    return keys;
}

ordered_json read_value(const SceneOverride& override)
{
    const std::string& text = override.value;
    const std::size_t first = text.find_first_not_of(" \t");
    const bool structured =
        first != std::string::npos && (text[first] == '{' || text[first] == '[' || text[first] == '"');
    if (structured) // a slip in a list or object is reported, not taken as a string
        return parse_json(text, "--set " + printable(override.key_path));
    ordered_json value = ordered_json::parse(text, nullptr, false);
    return value.is_discarded() ? ordered_json(text) : value;
}

ordered_json& step_into(ordered_json& at, const std::string& key, const SceneOverride& override)
{
    if (at.is_null())
        at = ordered_json::object();
    if (at.is_object())
        return at[key];
    require(at.is_array(), "--set {}: there is nothing below a plain value to set at \"{}\"",
            printable(override.key_path), printable(key));
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
    require(error == std::errc() && end == key.data() + key.size(), "--set {}: \"{}\" must be an index into a list",
            printable(override.key_path), printable(key));
    require(index < at.size(), "--set {}: index {} is beyond the list's {} entries (they count from 0)",
            printable(override.key_path), index, at.size());
    return at[index];
}

void drop_alternatives(ordered_json& scene, const std::vector<std::string>& keys)
{
    if (keys.size() < 2)
        return;
    for (const ExclusiveKeys& group : exclusive_keys) {
        if (group.section != keys[0] || std::find(group.keys.begin(), group.keys.end(), keys[1]) == group.keys.end())
            continue;
        const auto section = scene.find(keys[0]);
        if (section == scene.end() || !section->is_object())
            return;
        for (const std::string_view other : group.keys)
            if (other != keys[1])
                section->erase(std::string(other));
    }
}

} // namespace

void apply_overrides(ordered_json& scene, const std::vector<SceneOverride>& overrides)
{
    for (const SceneOverride& override : overrides) {
        const std::vector<std::string> keys = split_path(override);
        ordered_json value = read_value(override);
        drop_alternatives(scene, keys);
        ordered_json* at = &scene;
        for (const std::string& key : keys)
            at = &step_into(*at, key, override);
        *at = std::move(value);
    }
}

} // namespace lumisweep
