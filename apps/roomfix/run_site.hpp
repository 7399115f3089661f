// Runs a site to the end of its sources: what `run` and `replay` have in common.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "command_line.hpp"
#include "roomfix/pipeline/background_source.hpp"
#include "roomfix/pipeline/session_parts.hpp"
#include "roomfix/pipeline/site_watch.hpp"
#include "roomfix/pipeline/source_runner.hpp"
#include "roomfix/smooth/smoother.hpp"

namespace roomfix {

/// What `run --record` is told.
struct RecordOptions {
    std::string folder;     // empty: nothing is recorded
    std::string site_file;  // of the site that runs
    RecordingLimits limits;
};

struct RunOptions {
    std::string fixes;    // file, "-" for stdout, empty: as the site file says
    bool append = false;  // to that file
    bool page = true;
    bool outputs = true;  // those of the site file: brokers, databases
    std::string host;     // of the page; empty: as the site file says
    int port = -1;
    bool insecure = false;  // the page may be open to everybody who reaches this machine
    RunSettings run;
    SiteWatch* watch = nullptr;               // of the site file: zones that are drawn while it runs; null: none are
    const std::atomic<bool>* stop = nullptr;  // ends it early; null: what the terminal says
    std::optional<SmootherSettings> smooth;   // fixes are smoothed after the end
    RecordOptions record;
    std::vector<std::string> background;  // for all cameras; empty: as the site file says
};

/// Adds --background and --threads (by default all that the machine has) to a command that goes through a recording.
void add_recording_options(Command& command, std::vector<std::string>& background, int& threads);

/// Progress bars on the terminal while backgrounds are learned.
BackgroundListener background_on_terminal();

/// Says on stderr what goes on, and returns the exit code.
int run_site(const Site& site, const RunOptions& options);

}  // namespace roomfix
