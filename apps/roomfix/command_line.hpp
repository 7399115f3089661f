// Commands with their options and arguments. The library behind it is read by command_line.cpp alone: its headers cost each file that includes them seconds.
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace roomfix {

// Exit codes.
constexpr int done = 0;
constexpr int failed = 1;
constexpr int bad_input = 2;

/// What was just added to a command, for rules about its value.
class CommandOption {
public:
    explicit CommandOption(CLI::Option* option) : option_(option) {}

    CommandOption& required();
    CommandOption& range(double lowest, double highest);
    CommandOption& range(int lowest, int highest);
    CommandOption& one_of(std::initializer_list<const char*> values);
    /// It makes sense together with the other option only.
    CommandOption& needs(CommandOption other);
    CommandOption& needs(const std::string& other);
    /// The help states the value that the variable has now.
    CommandOption& show_default();

private:
    CLI::Option* option_;
};

/// A command, or a group of options in it. Variables that options are read into must live as long as the command line.
/// A name that starts with a dash is an option's, any other one that of an argument by its position.
class Command {
public:
    /// `exit_code`: where the command that runs puts its own.
    Command(CLI::App& app, int& exit_code) : app_(&app), exit_code_(&exit_code) {}

    Command add_command(const std::string& name, const std::string& description);
    /// Exactly one of the options that are added to the group is given.
    Command add_choice(const std::string& name);

    CommandOption option(const std::string& name, std::string& value, const std::string& description);
    CommandOption option(const std::string& name, int& value, const std::string& description);
    CommandOption option(const std::string& name, std::uint64_t& value, const std::string& description);
    CommandOption option(const std::string& name, double& value, const std::string& description);
    CommandOption option(const std::string& name, std::optional<double>& value, const std::string& description);
    CommandOption option(const std::string& name, std::vector<std::string>& values, const std::string& description);
    CommandOption flag(const std::string& name, bool& value, const std::string& description);
    /// One value each time that the option is given, so that what stands behind it is left to the command's other arguments.
    CommandOption repeatable(const std::string& name, std::vector<std::string>& values, const std::string& description);
    /// Exactly `count` numbers.
    CommandOption numbers(const std::string& name, std::vector<double>& values, int count, const std::string& description);

    void footer(const std::string& text);
    /// One of the commands below this one has to be given.
    void require_command();
    /// What it does; returns the exit code.
    void on_run(std::function<int()> run);

private:
    CLI::App* app_;
    int* exit_code_;
};

/// Reads the command line and runs the command that it names. `add_commands` gets the whole program, to which it adds them. Returns the exit code.
int run_command_line(int argc, char** argv, const std::string& description, const std::string& version, const std::function<void(Command&)>& add_commands);

}  // namespace roomfix
