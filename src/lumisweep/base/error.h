// Errors as users meet them: one line that says what is wrong, where, and how to mend it.
#pragma once

#include <cassert>
#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace lumisweep {

/// The only exception type that the library throws on purpose. `what()` is one line for the user:
/// "WHERE: WHAT (MEND)". Bad input is an Error, never a crash; std::bad_alloc may pass through.
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Throws Error with a formatted message.
template <class... Args>
[[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args)
{
    throw Error(fmt::format(format, std::forward<Args>(args)...));
}

/// Throws Error unless `ok`; for checks of user input, always on.
template <class... Args>
void require(bool ok, fmt::format_string<Args...> format, Args&&... args)
{
    if (!ok)
        throw Error(fmt::format(format, std::forward<Args>(args)...));
}

} // namespace lumisweep

/// Preconditions between our own functions: checked in builds without NDEBUG only.
#define LUMISWEEP_EXPECT(condition) assert(condition)
