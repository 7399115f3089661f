#include "calibrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "commands.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/calibrate/charuco.hpp"
#include "roomfix/calibrate/lens.hpp"
#include "roomfix/site/load_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

constexpr double clearly_worse = 1.05;  // times

std::string what_is(const SiteEdit& edit) { return (edit.section == "robots" ? "robot " : "camera ") + edit.id; }

/// As lines of a site file.
void show(const std::vector<SiteResult>& results) {
    for (const SiteResult& result : results) {
        if (results.size() > 1) fmt::print("{}:\n", result.edit.id);
        for (const SiteValue& v : result.edit.values) {
            if (!v.value.empty()) fmt::print("    {}: {}\n", v.key, v.value);
        }
    }
}

}  // namespace

int give_up(const Error& error) {
    complain(error.message);
    return bad_input;
}

Result<Chessboard> parse_board(const std::string& text, double square_mm, const std::string& dictionary, double marker_mm) {
    const auto x = text.find('x');
    const auto columns = parse_integer(text.substr(0, x)), rows = x == std::string::npos ? std::nullopt : parse_integer(text.substr(x + 1));
    constexpr int least = 3, most = 400;
    if (!columns || !rows || std::min(*columns, *rows) < least || std::max(*columns, *rows) > most) {
        return Error{fmt::format("--board {}: write its inner corners, such as 9x6 ({} to {} each)", text, least, most)};
    }
    Chessboard board{static_cast<int>(*columns), static_cast<int>(*rows), 1e-3 * square_mm};
    if (dictionary.empty()) return board;
    board.markers = BoardMarkers{dictionary, 1e-3 * marker_mm};
    if (auto checked = check_charuco(board); !checked) return checked.error();
    return board;
}

Result<CameraInSite> load_camera(const std::string& site_file, const std::string& camera) {
    const auto site = load_site(site_file);
    if (!site) return Error{"the site file cannot be used:\n" + site.error().message};
    const SiteCamera* found = site->camera(camera);
    if (found == nullptr) return Error{fmt::format("there is no camera '{}' in {}", camera, site_file)};
    return CameraInSite{*site, *found};
}

void add_write_options(Command& command, WriteOptions& options) {
    command.flag("--write", options.write, "write the result into the site file; the old file is kept with its date");
    command.flag("--force", options.force, "write it even if the site file has a better one");
}

Quality lens_quality(const SiteCamera& camera, const CameraModel& model, const IntrinsicsMatrix& covariance) {
    Quality quality{.what = "px expected error over the picture"};
    const auto rms = [](const CameraModel& of, const IntrinsicsMatrix& known) {
        const Eigen::VectorXd errors = predicted_error(of, known, spread_pixels(of));
        return std::sqrt(errors.squaredNorm() / static_cast<double>(errors.size()));
    };
    if (!camera.intrinsics_covariance.isZero(0)) quality.before = rms(camera.model, camera.intrinsics_covariance);
    // A calibration without a covariance cannot be the better one.
    quality.now = covariance.isZero(0) ? 1e9 : rms(model, covariance);
    return quality;
}

int write_or_show(const std::string& site_file, const std::vector<SiteResult>& results, const WriteOptions& options) {
    if (!options.write) {
        show(results);
        if (!site_file.empty()) say("not written; --write puts it into the site file");
        return done;
    }
    std::vector<SiteEdit> edits;
    std::vector<std::string> written;
    for (const auto& [edit, quality] : results) {
        if (quality.before > 0 && quality.now > clearly_worse * quality.before && !options.force) {
            complain(fmt::format("not written: the site file has a better calibration of {} ({:.3g} against {:.3g} {}); --force replaces it", what_is(edit),
                                 quality.before, quality.now, quality.what));
            return failed;
        }
        edits.push_back(edit);
        written.push_back(what_is(edit));
    }
    const auto copy = write_site_values(site_file, edits);
    if (!copy) {
        complain(copy.error().message);
        return bad_input;
    }
    say(fmt::format("{}: {} written; the file as it was is {}", site_file, fmt::join(written, ", "), copy->string()));
    return done;
}

int write_or_show(const std::string& site_file, const std::string& camera, const std::vector<SiteValue>& values, const Quality& quality,
                  const WriteOptions& options) {
    return write_or_show(site_file, {{{camera, values}, quality}}, options);
}

void add_calibrate(Command& program) {
    Command command = program.add_command("calibrate", "measures what a site file should say");
    command.require_command();
    add_calibrate_lens(command);
    add_calibrate_lines(command);
    add_calibrate_floor(command);
    add_calibrate_corner(command);
    add_calibrate_grid(command);
    add_calibrate_mount(command);
    add_calibrate_robot(command);
    add_calibrate_site(command);
}

}  // namespace roomfix
