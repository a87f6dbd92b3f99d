// The program: one client of the library. Exit codes: 0 done, 1 failed, 2 wrong usage.
#include <cstdio>
#include <new>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "commands.h"
#include "lumisweep/base/version.h"

namespace {

enum ExitCode : int { done = 0, failed = 1, wrong_usage = 2 };

int complain(ExitCode code, std::string message)
{
    for (char& c : message)
        if (c == '\n' || c == '\r')
            c = ' ';
    fmt::print(stderr, "lumisweep: {}\n", message);
    return code;
}

} // namespace

int main(int argc, char** argv)
{
    try {
        spdlog::set_default_logger(spdlog::stderr_color_st("lumisweep"));
        spdlog::set_pattern("lumisweep: %^%l%$: %v");

        CLI::App app{"Renders volumes under natural light, without bias."};
        app.name("lumisweep");
        app.set_version_flag("--version", std::string("lumisweep ") + lumisweep::version());
        app.require_subcommand(1);
        lumisweep::cli::Command command;
        lumisweep::cli::add_render(app, command);
        lumisweep::cli::add_compare(app, command);
        lumisweep::cli::add_info(app, command);
        lumisweep::cli::add_sweep(app, command);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            if (error.get_exit_code() == 0)
                return app.exit(error); // --help and --version
            if (app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-')
                return complain(wrong_usage,
                                fmt::format("{}: unknown command (give render, compare, info or sweep)", argv[1]));
            return complain(wrong_usage,
                            fmt::format("{} (see lumisweep --help and lumisweep COMMAND --help)", error.what()));
        }
        command();
        if (std::fflush(stdout) != 0)
            return complain(failed, "standard output: cannot be written (is the disk full?)");
        return done;
    } catch (const lumisweep::cli::UsageError& error) {
        return complain(wrong_usage, error.what());
    } catch (const std::bad_alloc&) {
        return complain(failed, "not enough memory (take a smaller volume or image)");
    } catch (const std::exception& error) {
        return complain(failed, error.what());
    }
}
