// The parts of `roomfix calibrate`, and what they share.
#pragma once

#include <string>
#include <vector>

#include "command_line.hpp"
#include "roomfix/calibrate/chessboard.hpp"
#include "roomfix/site/edit_site.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

void add_calibrate_lens(Command& calibrate);
void add_calibrate_lines(Command& calibrate);
void add_calibrate_floor(Command& calibrate);
void add_calibrate_corner(Command& calibrate);
void add_calibrate_grid(Command& calibrate);
void add_calibrate_mount(Command& calibrate);
void add_calibrate_robot(Command& calibrate);
void add_calibrate_site(Command& calibrate);

/// Says what is wrong, and returns the exit code.
int give_up(const Error& error);

/// "9x6": a board's inner corners, across x down. `dictionary`: of its markers; empty: it has none.
Result<Chessboard> parse_board(const std::string& text, double square_mm, const std::string& dictionary = "", double marker_mm = 0);

/// A camera of a site file, with the site.
struct CameraInSite {
    Site site;
    SiteCamera camera;
};
Result<CameraInSite> load_camera(const std::string& site_file, const std::string& camera);

/// How `--write` goes about it.
struct WriteOptions {
    bool write = false;
    bool force = false;
};
/// Adds --write and --force.
void add_write_options(Command& command, WriteOptions& options);

/// A calibration's expected error, in a unit that the sentence names; 0: the site file does not state one.
struct Quality {
    double before = 0, now = 0;
    std::string what;  // such as "px over the picture"
};

/// How much better a lens is known than the one that the site has for the camera.
Quality lens_quality(const SiteCamera& camera, const CameraModel& model, const IntrinsicsMatrix& covariance);

struct SiteResult {
    SiteEdit edit;
    Quality quality;
};

/// Puts values into the site file, or prints them where that was not asked for. Refuses to replace a better calibration by a worse one
/// without --force. Returns the exit code.
int write_or_show(const std::string& site_file, const std::vector<SiteResult>& results, const WriteOptions& options);
/// The same for one camera.
int write_or_show(const std::string& site_file, const std::string& camera, const std::vector<SiteValue>& values, const Quality& quality,
                  const WriteOptions& options);

}  // namespace roomfix
