// What goes on while the program runs, with levels: plain in a terminal, with times in a file, with priorities in systemd's journal. All of it on stderr.
#pragma once

#include <functional>
#include <string>

#include "command_line.hpp"

namespace roomfix {

enum class LogLevel { debug, info, warning, error };

/// Adds --log-level to a command.
void add_log_level(Command& command, std::string& level);

/// What a command does, with messages of this level (as --log-level has it) and above. Messages that were held back as repeated are told at its end.
/// Returns its exit code.
int with_log(const std::string& level, const std::function<int()>& run);

/// May be called from any thread. The same text again and again is told a few times a minute, with how often it was held back.
void write_log(LogLevel level, const std::string& text);
inline void log_debug(const std::string& text) { write_log(LogLevel::debug, text); }
inline void log_info(const std::string& text) { write_log(LogLevel::info, text); }
inline void log_warning(const std::string& text) { write_log(LogLevel::warning, text); }
inline void log_error(const std::string& text) { write_log(LogLevel::error, text); }

}  // namespace roomfix
