// Talking to the person at the terminal: everything that is not a result goes to stderr.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>

namespace roomfix {

/// A progress bar on stderr if that is a terminal, otherwise nothing. Call the result with 0..1; it ends the line itself.
std::function<void(double)> progress_bar(const std::string& what);

void say(const std::string& text);
/// "roomfix: text"
void complain(const std::string& text);

/// False, with a complaint, where the file cannot be written.
bool write_file(const std::filesystem::path& file, const std::string& text);

/// Set by Ctrl-C and SIGTERM from the first call on; a second Ctrl-C ends the program at once.
std::atomic<bool>& stop_requested();

}  // namespace roomfix
