#include "log.hpp"

#include <fmt/format.h>
#include <spdlog/logger.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <map>
#include <memory>
#include <mutex>
#include <sstream>

#include "roomfix/base/repeat_filter.hpp"
#include "roomfix/base/steady_now.hpp"

namespace roomfix {
namespace {

enum class Reader { person, file, journal };

/// systemd names the file to which it connected stderr: it may have been redirected since.
bool is_journal() {
    const char* stated = std::getenv("JOURNAL_STREAM");
    struct stat file {};
    if (stated == nullptr || fstat(STDERR_FILENO, &file) != 0) return false;
    return fmt::format("{}:{}", file.st_dev, file.st_ino) == stated;
}

Reader reader_of_stderr() {
    if (isatty(STDERR_FILENO)) return Reader::person;
    return is_journal() ? Reader::journal : Reader::file;
}

/// How spdlog, the journal (syslog's priorities) and a file name a level.
struct Names {
    spdlog::level::level_enum level;
    int priority;
};
Names names_of(LogLevel level) {
    constexpr std::array<Names, 4> names = {{{spdlog::level::debug, 7}, {spdlog::level::info, 6}, {spdlog::level::warn, 4}, {spdlog::level::err, 3}}};
    return names[static_cast<std::size_t>(level)];
}

class Log {
public:
    Log() : reader_(reader_of_stderr()), logger_("roomfix", std::make_shared<spdlog::sinks::stderr_sink_mt>()) {
        const char* pattern = reader_ == Reader::file ? "%Y-%m-%dT%H:%M:%S.%eZ %l: %v" : "%v";
        logger_.set_formatter(std::make_unique<spdlog::pattern_formatter>(pattern, spdlog::pattern_time_type::utc));
        logger_.flush_on(spdlog::level::debug);
    }

    void set_level(LogLevel level) { logger_.set_level(names_of(level).level); }

    void take(LogLevel level, const std::string& text) {
        if (!logger_.should_log(names_of(level).level)) return;
        const std::lock_guard lock(mutex_);
        if (const auto told = filter_.pass(text, steady_now())) write(level, *told);
    }

    void tell_rest() {
        const std::lock_guard lock(mutex_);
        for (const std::string& text : filter_.rest()) write(LogLevel::warning, text);
        filter_ = RepeatFilter();
    }

private:
    void write(LogLevel level, const std::string& text) {
        const Names names = names_of(level);
        if (reader_ == Reader::person) return logger_.log(names.level, "{}{}", level == LogLevel::error ? "roomfix: " : "", text);
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);) {
            logger_.log(names.level, "{}{}", reader_ == Reader::journal ? fmt::format("<{}>", names.priority) : "", line);
        }
    }

    Reader reader_;
    spdlog::logger logger_;
    std::mutex mutex_;  // guards:
    RepeatFilter filter_;
};

Log& the_log() {
    static Log log;
    return log;
}

}  // namespace

void add_log_level(Command& command, std::string& level) {
    command.option("--log-level", level, "what is told on stderr").show_default().one_of({"debug", "info", "warning", "error"});
}

int with_log(const std::string& level, const std::function<int()>& run) {
    static const std::map<std::string, LogLevel> levels = {
        {"debug", LogLevel::debug}, {"info", LogLevel::info}, {"warning", LogLevel::warning}, {"error", LogLevel::error}};
    the_log().set_level(levels.at(level));
    const int exit_code = run();
    the_log().tell_rest();
    return exit_code;
}

void write_log(LogLevel level, const std::string& text) { the_log().take(level, text); }

}  // namespace roomfix
