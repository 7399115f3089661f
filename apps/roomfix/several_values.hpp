// Options with several values that leave what stands behind them to the command's other arguments.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace roomfix {

/// One value each time that the option is given.
inline CLI::Option* add_repeatable(CLI::App& command, const std::string& name, std::vector<std::string>& values, const std::string& description) {
    return command.add_option(name, values, description + "; give it once for each")->allow_extra_args(false);
}

/// Exactly `count` numbers.
inline CLI::Option* add_numbers(CLI::App& command, const std::string& name, std::vector<double>& values, int count, const std::string& description) {
    return command.add_option(name, values, description)->expected(count)->allow_extra_args(false);
}

}  // namespace roomfix
