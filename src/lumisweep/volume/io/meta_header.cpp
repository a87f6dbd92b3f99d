#include "lumisweep/volume/io/meta_header.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>

#include "lumisweep/base/error.h"

namespace lumisweep {

namespace {

constexpr std::size_t max_header_bytes = std::size_t(1) << 16;

std::string trimmed(const std::string& s)
{
    const auto is_space = [](unsigned char c) { return std::isspace(c) != 0; };
    const auto first = std::find_if_not(s.begin(), s.end(), is_space);
    const auto last = std::find_if_not(s.rbegin(), std::make_reverse_iterator(first), is_space).base();
    return {first, last};
}

std::string lower(std::string s)
{
    std::transform(s.begin(), s.end(), s.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return s;
}

/// As messages show what a file says: printable and short.
std::string quoted(const std::string& s)
{
    std::string out = s.substr(0, 40);
    for (char& c : out)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e)
            c = '?';
    return "\"" + out + "\"";
}

std::vector<double> parse_numbers(const std::string& text)
{
    std::vector<double> out;
    const char* at = text.c_str();
    for (;;) {
        char* end = nullptr;
        const double v = std::strtod(at, &end);
        if (end == at)
            break;
        out.push_back(v);
        at = end;
    }
    // Rest that is no number: not a list of numbers.
    if (!trimmed(at).empty())
        out.clear();
    return out;
}

} // namespace

MetaHeader::MetaHeader(const std::filesystem::path& path) : where_(path.string())
{
    std::ifstream in(path, std::ios::binary);
    require(in.good(), "{}: cannot be opened (check the path and its permissions)", where_);
    std::string start(max_header_bytes, '\0');
    in.read(start.data(), static_cast<std::streamsize>(start.size()));
    start.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));

    std::size_t at = 0;
    while (at < start.size()) {
        const std::size_t end = std::min(start.find('\n', at), start.size());
        const std::string line = start.substr(at, end - at);
        at = std::min(end + 1, start.size());
        const auto equals = line.find('=');
        if (equals == std::string::npos) {
            require(trimmed(line).empty(), "{}: not a MetaImage, line {} is not \"Key = value\" (check the file type)",
                    where_, quoted(line));
            continue;
        }
        const std::string key = lower(trimmed(line.substr(0, equals)));
        fields_[key] = trimmed(line.substr(equals + 1));
        if (key == "elementdatafile") {
            bytes_ = at;
            return;
        }
    }
    fail("{}: not a MetaImage, ElementDataFile is missing in the header (check the file type)", where_);
}

std::string MetaHeader::text(const std::string& key) const
{
    const auto found = fields_.find(lower(key));
    return found == fields_.end() ? std::string() : found->second;
}

bool MetaHeader::flag(const std::string& key) const
{
    const std::string value = lower(text(key));
    return !value.empty() && (value[0] == 't' || value[0] == 'y' || value[0] == '1');
}

std::vector<double> MetaHeader::numbers(const std::string& key, std::size_t count) const
{
    const std::string value = text(key);
    if (value.empty())
        return {};
    std::vector<double> list = parse_numbers(value);
    require(list.size() == count, "{}: {} = {} should be {} numbers (mend the header)", where_, key, quoted(value),
            count);
    return list;
}

std::int64_t MetaHeader::integer(const std::string& key, std::int64_t otherwise) const
{
    const auto list = numbers(key, 1);
    if (list.empty())
        return otherwise;
    require(list[0] == std::floor(list[0]) && std::abs(list[0]) < 9e15,
            "{}: {} = {} should be a whole number (mend the header)", where_, key, quoted(text(key)));
    return static_cast<std::int64_t>(list[0]);
}

} // namespace lumisweep
