#include "lumisweep/volume/io/expand_files.h"

#include <algorithm>
#include <memory>

#include <glob.h>

#include "lumisweep/base/error.h"

namespace lumisweep {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Cuts the leading run of digits off `text`.
std::string_view take_digits(std::string_view& text)
{
    std::size_t n = 0;
    while (n < text.size() && is_digit(text[n]))
        ++n;
    const std::string_view digits = text.substr(0, n);
    text.remove_prefix(n);
    return digits;
}

std::string_view without_zeros(std::string_view digits)
{
    return digits.substr(std::min(digits.find_first_not_of('0'), digits.size()));
}

} // namespace

bool natural_less(std::string_view a, std::string_view b)
{
    const std::string_view whole_a = a, whole_b = b;
    while (!a.empty() && !b.empty()) {
        if (is_digit(a.front()) && is_digit(b.front())) {
            const std::string_view number_a = without_zeros(take_digits(a));
            const std::string_view number_b = without_zeros(take_digits(b));
            if (number_a.size() != number_b.size())
                return number_a.size() < number_b.size();
            if (number_a != number_b)
                return number_a < number_b;
        } else {
            if (a.front() != b.front())
                return a.front() < b.front();
            a.remove_prefix(1);
            b.remove_prefix(1);
        }
    }
    if (a.empty() != b.empty())
        return a.empty();
    // Equal up to leading zeros.
    if (whole_a.size() != whole_b.size())
        return whole_a.size() < whole_b.size();
    return whole_a < whole_b;
}

std::vector<std::filesystem::path> expand_files(const std::string& pattern)
{
    std::error_code ignored;
    if (std::filesystem::exists(pattern, ignored))
        return {pattern}; // a name that happens to contain brackets
    glob_t found{};
    const std::unique_ptr<glob_t, decltype(&globfree)> release(&found, &globfree);
    const int status = glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found);
    require(status == 0 && found.gl_pathc > 0, "{}: no file matches (check the folder and the pattern's * ? [ ])",
            pattern);
    std::vector<std::filesystem::path> files(found.gl_pathv, found.gl_pathv + found.gl_pathc);
    std::sort(files.begin(), files.end(),
              [](const auto& a, const auto& b) { return natural_less(a.native(), b.native()); });
    return files;
}

} // namespace lumisweep
