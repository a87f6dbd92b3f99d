#include "lumisweep/scene/json_reader.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lumisweep/base/error.h"
#include "lumisweep/scene/json_text.h"

namespace lumisweep {

namespace {

using nlohmann::ordered_json;

/// What a value is, in words: "a string".
const char* kind_of(const ordered_json& value)
{
    switch (value.type()) {
    case ordered_json::value_t::null: return "null";
    case ordered_json::value_t::boolean: return "true or false";
    case ordered_json::value_t::string: return "a string";
    case ordered_json::value_t::array: return "a list";
    case ordered_json::value_t::object: return "an object";
    default: return "a number";
    }
}

std::size_t edit_distance(std::string_view a, std::string_view b)
{
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i + 1;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t substituted = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

template <class Names>
std::string listed(const Names& names)
{
    return fmt::format("{}", fmt::join(names, ", "));
}

} // namespace

JsonPlace JsonPlace::at(std::string_view key) const
{
    return {file, path.empty() ? std::string(key) : fmt::format("{}.{}", path, key)};
}
JsonPlace JsonPlace::at(std::size_t index) const { return at(std::to_string(index)); }
std::string JsonPlace::text() const { return path.empty() ? file : fmt::format("{}: {}", file, printable(path)); }

bool NumberRange::contains(double value) const
{
    const bool above = ends == Ends::closed ? value >= low : value > low;
    const bool below = ends == Ends::open ? value < high : value <= high;
    return above && below;
}

std::string NumberRange::text() const
{
    return fmt::format("{} {} and {} {}", ends == Ends::closed ? "at least" : "more than", low,
                       ends == Ends::open ? "less than" : "at most", high);
}

double read_number(const ordered_json& value, const JsonPlace& place, const NumberRange& range)
{
    require(value.is_number(), "{}: must be a number, not {}", place.text(), kind_of(value));
    const double number = value.get<double>();
    require(range.contains(number), "{}: {} is out of range (give {})", place.text(), number, range.text());
    return number;
}

Vec3d read_vector(const ordered_json& value, const JsonPlace& place, const NumberRange& range)
{
    require(value.is_array() && value.size() == 3, "{}: must be a list of three numbers, not {}", place.text(),
            value.is_array() ? fmt::format("of {}", value.size()) : kind_of(value));
    return {read_number(value[0], place.at(0), range), read_number(value[1], place.at(1), range),
            read_number(value[2], place.at(2), range)};
}

const std::string& read_string(const ordered_json& value, const JsonPlace& place)
{
    require(value.is_string(), "{}: must be a string, not {}", place.text(), kind_of(value));
    return value.get_ref<const std::string&>();
}

std::uint64_t read_whole(const ordered_json& value, const JsonPlace& place, std::uint64_t low, std::uint64_t high)
{
    require(value.is_number(), "{}: must be a whole number, not {}", place.text(), kind_of(value));
    std::optional<std::uint64_t> whole;
    if (value.is_number_unsigned()) {
        whole = value.get<std::uint64_t>();
    } else if (value.is_number_float()) {
        const double number = value.get<double>();
        if (number >= 0.0 && number < 9007199254740992.0 && number == std::floor(number)) // exact below 2^53
            whole = static_cast<std::uint64_t>(number);
    }
    require(whole && *whole >= low && *whole <= high, "{}: {} is out of range (give a whole number from {} to {})",
            place.text(), value.dump(), low, high);
    return *whole;
}

std::string nearest_word(std::string_view word, std::span<const std::string_view> candidates)
{
    std::string nearest;
    if (word.size() > 64)
        return nearest;
    std::size_t best = std::max<std::size_t>(word.size() / 2, 2);
    for (const std::string_view candidate : candidates) {
        const std::size_t distance = edit_distance(word, candidate);
        if (distance < best || (distance == best && nearest.empty())) {
            best = distance;
            nearest = candidate;
        }
    }
    return nearest;
}

ObjectReader::ObjectReader(const ordered_json& value, JsonPlace place, std::initializer_list<std::string_view> known)
    : value_(value), place_(std::move(place))
{
    require(value.is_object(), "{}: must be an object {{...}}, not {}", place_.text(), kind_of(value));
    const std::span<const std::string_view> keys(known.begin(), known.size());
    for (const auto& item : value.items()) {
        if (std::find(keys.begin(), keys.end(), item.key()) != keys.end())
            continue;
        const std::string nearest = nearest_word(item.key(), keys);
        if (!nearest.empty())
            fail("{}: unknown key (did you mean \"{}\"?)", place_.at(item.key()).text(), nearest);
        fail("{}: unknown key (known here: {})", place_.at(item.key()).text(), listed(keys));
    }
}

const ordered_json* ObjectReader::find(std::string_view key) const
{
    const auto found = value_.find(std::string(key));
    return found == value_.end() ? nullptr : &*found;
}

const ordered_json& ObjectReader::required(std::string_view key) const
{
    const ordered_json* found = find(key);
    require(found != nullptr, "{}: missing (add it)", place_.at(key).text());
    return *found;
}

void ObjectReader::at_most_one(std::initializer_list<std::string_view> keys) const
{
    std::vector<std::string_view> present;
    for (const std::string_view key : keys)
        if (find(key) != nullptr)
            present.push_back(key);
    require(present.size() <= 1, "{}: has {} (give one of them)", place_.text(), fmt::join(present, " and "));
}

void ObjectReader::number(std::string_view key, double& target, const NumberRange& range) const
{
    if (const ordered_json* found = find(key))
        target = read_number(*found, place(key), range);
}

void ObjectReader::number(std::string_view key, std::optional<double>& target, const NumberRange& range) const
{
    if (const ordered_json* found = find(key))
        target = read_number(*found, place(key), range);
}

void ObjectReader::whole(std::string_view key, int& target, int low, int high) const
{
    if (const ordered_json* found = find(key))
        target = static_cast<int>(
            read_whole(*found, place(key), static_cast<std::uint64_t>(low), static_cast<std::uint64_t>(high)));
}

void ObjectReader::vector(std::string_view key, Vec3d& target, const NumberRange& range) const
{
    if (const ordered_json* found = find(key))
        target = read_vector(*found, place(key), range);
}

void ObjectReader::vector(std::string_view key, std::optional<Vec3d>& target, const NumberRange& range) const
{
    if (const ordered_json* found = find(key))
        target = read_vector(*found, place(key), range);
}

void ObjectReader::boolean(std::string_view key, bool& target) const
{
    const ordered_json* found = find(key);
    if (found == nullptr)
        return;
    require(found->is_boolean(), "{}: must be true or false, not {}", place(key).text(), kind_of(*found));
    target = found->get<bool>();
}

std::optional<std::size_t> ObjectReader::choice(std::string_view key, std::span<const std::string_view> names) const
{
    const ordered_json* found = find(key);
    if (found == nullptr)
        return std::nullopt;
    const std::string& word = read_string(*found, place(key));
    const auto match = std::find(names.begin(), names.end(), word);
    require(match != names.end(), "{}: \"{}\" is not known (give one of {})", place(key).text(), printable(word),
            listed(names));
    return static_cast<std::size_t>(match - names.begin());
}

} // namespace lumisweep
