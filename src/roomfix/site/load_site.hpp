// site.yaml, format 1, read into plain values and checked whole.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// Something wrong with a site file, or worth knowing about it.
struct Problem {
    int line = 0;    // 1-based; 0: the file as a whole
    int column = 0;  // 1-based
    bool fatal = true;
    std::string message;  // what is wrong and what to write instead
};

struct LoadedSite {
    Site site;                      // complete only if there is no fatal problem
    std::vector<Problem> problems;  // in the order of the file

    bool usable() const {
        for (const auto& p : problems) {
            if (p.fatal) return false;
        }
        return true;
    }
};

/// Reads a site from text. Never throws; every problem found is reported at once.
LoadedSite parse_site(std::string_view text, const std::filesystem::path& folder);

/// Reads a site file and finds everything wrong with it. A file that cannot be read is one fatal problem.
LoadedSite inspect_site(const std::filesystem::path& file);

/// The site, or one Error that lists all fatal problems, each on a line "FILE:LINE:COLUMN: message".
Result<Site> load_site(const std::filesystem::path& file);

/// The site file of a session's folder; anything else is taken for a site file itself.
std::filesystem::path site_file_of(const std::filesystem::path& session);

/// The site of a session's folder, or of a site file. What the folder's odometry.csv and ranges.csv hold of robots whose source the file leaves open is
/// theirs. Errors as of load_site().
Result<Site> load_session(const std::filesystem::path& session);

/// "FILE:LINE:COLUMN: error: message"
std::string problem_text(const std::filesystem::path& file, const Problem& problem);

}  // namespace roomfix
