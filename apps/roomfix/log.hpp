// What goes on while the program runs, with levels: plain in a terminal, with times in a file, with priorities in systemd's journal. All of it on stderr.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace roomfix {

enum class LogLevel { debug, info, warning, error };

/// Adds --log-level to a command.
void add_log_level(CLI::App& command, LogLevel& level);

/// From now on messages below this level are not told.
void begin_log(LogLevel level);
/// Tells what was held back as repeated. Nothing is held back after it.
void end_log();

/// May be called from any thread. The same text again and again is told a few times a minute, with how often it was held back.
void write_log(LogLevel level, const std::string& text);
inline void log_debug(const std::string& text) { write_log(LogLevel::debug, text); }
inline void log_info(const std::string& text) { write_log(LogLevel::info, text); }
inline void log_warning(const std::string& text) { write_log(LogLevel::warning, text); }
inline void log_error(const std::string& text) { write_log(LogLevel::error, text); }

}  // namespace roomfix
