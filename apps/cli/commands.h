// The subcommands: each adds its options and says what to run once the command line has been understood.
#pragma once

#include <functional>
#include <stdexcept>

namespace CLI {
class App;
}

namespace lumisweep::cli {

/// Wrong usage that only shows after the options have been read: exit code 2.
class UsageError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Set by the subcommand that was given.
using Command = std::function<void()>;

void add_render(CLI::App& app, Command& command);
void add_compare(CLI::App& app, Command& command);
void add_info(CLI::App& app, Command& command);
void add_sweep(CLI::App& app, Command& command);

} // namespace lumisweep::cli
