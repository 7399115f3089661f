#include "command_line.hpp"

#include <CLI/CLI.hpp>
#include <utility>

namespace roomfix {

CommandOption& CommandOption::required() {
    option_->required();
    return *this;
}

CommandOption& CommandOption::range(double lowest, double highest) {
    option_->check(CLI::Range(lowest, highest));
    return *this;
}

CommandOption& CommandOption::range(int lowest, int highest) {
    option_->check(CLI::Range(lowest, highest));
    return *this;
}

CommandOption& CommandOption::one_of(std::initializer_list<const char*> values) {
    option_->check(CLI::IsMember(std::vector<std::string>(values.begin(), values.end())));
    return *this;
}

CommandOption& CommandOption::needs(CommandOption other) {
    option_->needs(other.option_);
    return *this;
}

CommandOption& CommandOption::needs(const std::string& other) {
    option_->needs(other);
    return *this;
}

CommandOption& CommandOption::show_default() {
    option_->capture_default_str();
    return *this;
}

Command Command::add_command(const std::string& name, const std::string& description) { return Command(*app_->add_subcommand(name, description), *exit_code_); }

Command Command::add_choice(const std::string& name) {
    CLI::Option_group* group = app_->add_option_group(name);
    group->require_option(1);
    return Command(*group, *exit_code_);
}

CommandOption Command::option(const std::string& name, std::string& value, const std::string& description) {
    return CommandOption(app_->add_option(name, value, description));
}

CommandOption Command::option(const std::string& name, int& value, const std::string& description) {
    return CommandOption(app_->add_option(name, value, description));
}

CommandOption Command::option(const std::string& name, std::uint64_t& value, const std::string& description) {
    return CommandOption(app_->add_option(name, value, description));
}

CommandOption Command::option(const std::string& name, double& value, const std::string& description) {
    return CommandOption(app_->add_option(name, value, description));
}

CommandOption Command::option(const std::string& name, std::optional<double>& value, const std::string& description) {
    return CommandOption(app_->add_option(name, value, description));
}

CommandOption Command::option(const std::string& name, std::vector<std::string>& values, const std::string& description) {
    return CommandOption(app_->add_option(name, values, description));
}

CommandOption Command::flag(const std::string& name, bool& value, const std::string& description) {
    return CommandOption(app_->add_flag(name, value, description));
}

CommandOption Command::repeatable(const std::string& name, std::vector<std::string>& values, const std::string& description) {
    return CommandOption(app_->add_option(name, values, description + "; give it once for each")->allow_extra_args(false));
}

CommandOption Command::numbers(const std::string& name, std::vector<double>& values, int count, const std::string& description) {
    return CommandOption(app_->add_option(name, values, description)->expected(count)->allow_extra_args(false));
}

void Command::footer(const std::string& text) { app_->footer(text); }

void Command::require_command() { app_->require_subcommand(1); }

void Command::on_run(std::function<int()> run) {
    app_->callback([run = std::move(run), exit_code = exit_code_] { *exit_code = run(); });
}

int run_command_line(int argc, char** argv, const std::string& description, const std::string& version, const std::function<void(Command&)>& add_commands) {
    CLI::App app{description};
    app.set_version_flag("--version", version);
    int exit_code = done;
    Command program(app, exit_code);
    add_commands(program);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& problem) {
        return app.exit(problem) == 0 ? done : bad_input;
    }
    return exit_code;
}

}  // namespace roomfix
