#include "lumisweep/scene/json_text.h"

#include <algorithm>
#include <fstream>
#include <set>
#include <vector>

#include "lumisweep/base/error.h"

namespace lumisweep {

namespace {

using nlohmann::ordered_json;

struct TextPosition {
    std::size_t line = 1, column = 1;
};

TextPosition position_of(std::string_view text, std::size_t byte)
{
    TextPosition position;
    const std::string_view before = text.substr(0, std::min(byte, text.size()));
    position.line += static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n'));
    const std::size_t line_start = before.rfind('\n');
    position.column += before.size() - (line_start == std::string_view::npos ? 0 : line_start + 1);
    return position;
}

/// nlohmann's message without its prefix "[json.exception.… ] parse error at line 1, column 2: ".
std::string reason_of(const std::exception& error)
{
    const std::string_view what = error.what();
    for (const std::string_view marker : {"column ", "] "}) {
        const std::size_t at = what.find(marker);
        if (at == std::string_view::npos)
            continue;
        const std::size_t colon = marker == "] " ? at : what.find(": ", at);
        if (colon != std::string_view::npos)
            return printable(what.substr(colon + 2), 160);
    }
    return printable(what, 160);
}

/// Watches the parser's events for what nlohmann itself lets pass: duplicate keys and deep nesting.
class StrictEvents {
public:
    explicit StrictEvents(const std::string& name) : name_(name) {}

    bool operator()(int depth, ordered_json::parse_event_t event, ordered_json& parsed)
    {
        switch (event) {
        case ordered_json::parse_event_t::object_start:
        case ordered_json::parse_event_t::array_start:
            require(depth < max_json_depth, "{}: nested deeper than {} levels (flatten it)", name_, max_json_depth);
            keys_.emplace_back();
            break;
        case ordered_json::parse_event_t::object_end:
        case ordered_json::parse_event_t::array_end: keys_.pop_back(); break;
        case ordered_json::parse_event_t::key: {
            const std::string key = parsed.get<std::string>();
            require(keys_.back().insert(key).second, "{}: the key \"{}\" is given twice in one object (remove one)",
                    name_, printable(key));
            break;
        }
        case ordered_json::parse_event_t::value: break;
        }
        return true;
    }

private:
    std::string name_;
    std::vector<std::set<std::string>> keys_;
};

} // namespace

ordered_json parse_json(std::string_view text, const std::string& name)
{
    // A zero byte ends the text for nlohmann's lexer, so that whatever follows it would pass unread.
    const std::size_t zero = text.find('\0');
    if (zero != std::string_view::npos) {
        const TextPosition at = position_of(text, zero);
        fail("{}: line {}, column {}: a zero byte (not a JSON text)", name, at.line, at.column);
    }
    try {
        return ordered_json::parse(text.begin(), text.end(), StrictEvents(name), true, true);
    } catch (const ordered_json::parse_error& error) {
        const TextPosition at = position_of(text, error.byte == 0 ? 0 : error.byte - 1);
        fail("{}: line {}, column {}: {}", name, at.line, at.column, reason_of(error));
    } catch (const ordered_json::exception& error) {
        fail("{}: {}", name, reason_of(error));
    }
}

std::string read_text_file(const std::filesystem::path& file)
{
    std::error_code ignored;
    require(std::filesystem::exists(file, ignored), "{}: no such file (check the path)", file.string());
    require(!std::filesystem::is_directory(file, ignored), "{}: is a directory (give a file)", file.string());
    std::ifstream in(file, std::ios::binary);
    require(in.good(), "{}: cannot be opened (check its permissions)", file.string());
    std::string text;
    std::vector<char> chunk(std::size_t{1} << 16);
    while (in.read(chunk.data(), static_cast<std::streamsize>(chunk.size())) || in.gcount() > 0) {
        text.append(chunk.data(), static_cast<std::size_t>(in.gcount()));
        require(text.size() <= max_json_bytes, "{}: larger than {} MiB (not a scene; give the volume with --volume)",
                file.string(), max_json_bytes >> 20);
    }
    require(!in.bad(), "{}: cannot be read", file.string());
    return text;
}

std::string printable(std::string_view text, std::size_t limit)
{
    std::string out(text.substr(0, limit));
    for (char& c : out)
        if (c < 0x20 || c > 0x7e)
            c = '?';
    if (text.size() > limit)
        out += "...";
    return out;
}

} // namespace lumisweep
