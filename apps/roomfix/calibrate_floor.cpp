#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <sstream>

#include "calibrate.hpp"
#include "commands.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/overlay.hpp"
#include "roomfix/overhead/li2014.hpp"
#include "roomfix/pipeline/background_source.hpp"
#include "roomfix/pipeline/floor_session.hpp"
#include "roomfix/site/site_text.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string site, camera, picture, overlay;
    std::vector<std::string> points;
    std::string tile, tile_at = "0,0,0";
    double tile_size_mm = 300, tile_size_sigma_mm = 0.15;
    double height = 0;
    FloorOptions options;
    bool no_grid = false;
    WriteOptions write;
};

Result<FloorOptions> options_of(const Arguments& arguments) {
    FloorOptions options = arguments.options;
    for (const std::string& text : arguments.points) {
        const auto equals = text.find('=');
        const auto pixel = parse_numbers(text.substr(0, equals));
        const auto map = equals == std::string::npos ? std::nullopt : parse_numbers(text.substr(equals + 1));
        if (!pixel || !map || pixel->size() != 2 || map->size() != 2) {
            return Error{fmt::format("--point {}: write the pixel and its place on the floor in metres, such as 321.5,240=1.2,3.4", text)};
        }
        options.points.push_back({{(*pixel)[0], (*pixel)[1]}, {(*map)[0], (*map)[1]}});
    }
    std::istringstream corners(arguments.tile);
    for (std::string corner; corners >> corner;) {
        const auto pixel = parse_numbers(corner);
        if (!pixel || pixel->size() != 2) return Error{fmt::format("--tile: {} is no pixel: write four, such as \"310,400 380,402 375,370 312,369\"", corner)};
        options.tile.emplace_back((*pixel)[0], (*pixel)[1]);
    }
    const auto at = parse_numbers(arguments.tile_at);
    if (!at || at->size() != 3)
        return Error{fmt::format("--tile-at {}: write the first corner's x, y in metres and the first side's direction in degrees, such as 1.2,0,90",
                                 arguments.tile_at)};
    options.grid = {{(*at)[0], (*at)[1], radians((*at)[2])}, 1e-3 * arguments.tile_size_mm, 1e-3 * arguments.tile_size_sigma_mm};
    if (arguments.height > 0) options.height = arguments.height;
    options.follow_joints = !arguments.no_grid;
    return options;
}

/// The picture that was given, or the first of the camera's background or source.
Result<LumaImage> picture_of(const Site& site, const SiteCamera& camera, const std::string& given) {
    const std::string from = !given.empty() ? given : resolved_path(site, camera.background.empty() ? camera.source : camera.background);
    auto source = open_source(from);
    if (!source) return source.error();
    SourceFrame frame;
    const auto more = (*source)->next(frame);
    if (!more) return more.error();
    if (!*more) return Error{from + ": no picture in it"};
    return std::move(frame.image);
}

/// What is known without points on the command line: those of the site file.
void take_site_points(const SiteCamera& camera, FloorOptions& options) {
    const auto* known = std::get_if<KnownFloorPoints>(&camera.placement);
    if (known == nullptr || !options.points.empty()) return;
    options.points = known->points;
    options.click_sigma = known->sigma;
}

void print(const FloorSession& session, const SiteCamera& camera, const View& view) {
    const FloorCalibration& found = session.calibration;
    const Eigen::Vector3d p = view.position();
    const Matrix6d& c = view.map_from_camera.covariance;
    const bool has_sightings =
        std::any_of(found.contributions.begin(), found.contributions.end(), [](const FloorContribution& part) { return part.sightings > 0; });
    fmt::print("camera {}: at ({:.3f}, {:.3f}, {:.3f}) m +- ({:.1f}, {:.1f}, {:.1f}) mm, direction +- {:.2f} deg{}\n", camera.id, p.x(), p.y(), p.z(),
               1e3 * std::sqrt(c(0, 0)), 1e3 * std::sqrt(c(1, 1)), 1e3 * std::sqrt(c(2, 2)), degrees(std::sqrt(c(3, 3) + c(4, 4) + c(5, 5))),
               has_sightings ? fmt::format("; residual {:.2f} px", found.rms) : "");
    for (const FloorContribution& part : found.contributions) {
        const std::string seen = part.sightings > 0 ? fmt::format("{:5} sightings, {:.2f} px rms", part.sightings, part.rms) : "the whole pose";
        std::string alone =
            part.alone ? fmt::format("; alone it would leave {:.1f} mm on the floor", 1e3 * *part.alone) : "; alone it would not fix the camera";
        if (part.alone && !(*part.alone > 0)) alone.clear();
        fmt::print("  {:16} {}, {:3.0f} % of what is known{}\n", part.name, seen, 100 * part.share, alone);
    }
    const char* const lens = camera.intrinsics_covariance.isZero(0) ? ", if the lens is known exactly (calibrate lens)" : ", with that of the lens";
    if (found.floor_error > 0) {
        fmt::print("  expected error on the floor: {:.1f} mm rms{}\n", 1e3 * found.floor_error, lens);
    } else {
        fmt::print("  the camera sees no floor\n");
    }
}

/// The constants of Li et al. 2014, (18), as the published method would set them up here.
void print_published(const View& view) {
    const auto rectangle = li2014_rectangle_ahead(view);
    if (!rectangle) return;
    const auto webcam = Li2014::set_up(view.model, *rectangle, li2014_aisle_ahead(view));
    if (!webcam) return;
    fmt::print("  as published (Li 2014): IBDMS d = {:.2f} m px / N - {:.3f} m; PLDMS with D_N = {:.2f} m\n", webcam->ibdms_factor(), webcam->ibdms_offset(),
               rectangle->width);
}

/// mm, of where a camera is.
double place_error(const View& view) { return 1e3 * std::sqrt(view.map_from_camera.covariance.topLeftCorner<3, 3>().trace()); }

int calibrate_floor_command(const Arguments& arguments) {
    auto options = options_of(arguments);
    if (!options) return give_up(options.error());
    const auto place = load_camera(arguments.site, arguments.camera);
    if (!place) return give_up(place.error());
    const Site* site = &place->site;
    const SiteCamera* camera = &place->camera;
    if (std::holds_alternative<Mount>(camera->placement)) {
        return give_up(Error{fmt::format("camera {} rides on a robot: calibrate mount is what it needs", camera->id)});
    }
    if (options->tile.empty() && options->corner.empty()) take_site_points(*camera, *options);
    const auto picture = picture_of(*site, *camera, arguments.picture);
    if (!picture) return give_up(picture.error());
    const auto session = calibrate_floor_from(*site, *camera, *picture, *options);
    if (!session) return give_up(session.error());
    const FloorCalibration& found = session->calibration;
    const View view{camera->model, found.map_from_camera, {camera->intrinsics_covariance, found.by_intrinsics}};
    print(*session, *camera, view);
    print_published(view);
    // Without a picture given, it is one of the background's own.
    const auto offset = arguments.picture.empty() ? std::nullopt : offset_from_background(*site, *camera, *picture);
    if (offset) {
        say(
            fmt::format("the picture lies {:.1f} pixels beside the camera's background: the camera was moved between them; take a new background, or calibrate "
                        "with a picture of then",
                        *offset));
    }
    if (!arguments.overlay.empty()) {
        std::vector<Eigen::Vector2d> seen;
        for (const FloorSource& source : session->sources) {
            for (const FloorSighting& s : source.sightings) seen.push_back(s.pixel);
        }
        if (auto saved = save_floor_overlay(arguments.overlay, *picture, view, seen); !saved) return give_up(saved.error());
        say("overlay: " + arguments.overlay);
    }
    const auto before = fixed_view(*camera);
    Quality quality{before ? 1e3 * floor_error(*before) : 0, 1e3 * found.floor_error, "mm expected error on the floor"};
    if (!(found.floor_error > 0)) quality = {before ? place_error(*before) : 0, place_error(view), "mm expected error of the camera's place"};
    KnownPose known{found.map_from_camera, true, camera->intrinsics_covariance.isZero(0) ? PoseByIntrinsics::Zero() : found.by_intrinsics};
    std::vector<SiteValue> values = {{"pose", pose_text(known, camera->model)}};
    for (const char* old : {"floor_points", "floor_points_sigma", "height", "height_sigma", "robot"}) values.push_back({old, ""});
    return write_or_show(arguments.site, camera->id, values, quality, arguments.write);
}

}  // namespace

void add_calibrate_floor(Command& calibrate) {
    Command floor = calibrate.add_command("floor", "where a fixed camera is, from the floor it sees: points, tiles, tags, and from a room's corner");
    auto arguments = std::make_shared<Arguments>();
    floor.option("SITE", arguments->site, "site file").required();
    floor.option("--camera", arguments->camera, "camera that stands still").required();
    floor.option("--picture", arguments->picture, "picture without robots (default: the first of the camera's background or source)");
    floor.repeatable("--point", arguments->points, "pixel and its place on the floor, U,V=X,Y, four or more (default: the site file's floor_points)");
    floor.option("--click-sigma", arguments->options.click_sigma, "px: how exactly each coordinate was clicked").show_default().range(0.01, 50.0);
    floor.option("--tile", arguments->tile, "four corners of one tile: \"U,V U,V U,V U,V\", counter-clockwise seen from above");
    floor.option("--tile-size-mm", arguments->tile_size_mm, "from joint to joint").show_default().range(1.0, 10000.0);
    floor.option("--tile-size-sigma-mm", arguments->tile_size_sigma_mm, "how well that is known, on average over many tiles").show_default().range(0.0, 100.0);
    floor.option("--tile-at", arguments->tile_at, "X,Y,YAW: the tile's first corner in the map (m), and the direction of its first side (deg)").show_default();
    floor.flag("--no-grid", arguments->no_grid, "use the four clicks alone, do not look for the other tiles' joints");
    floor.option("--corner", arguments->options.corner, "corner of the site that the camera sees; needs --height");
    floor.option("--height", arguments->height, "m, of the camera above the floor").range(0.01, 1000.0);
    floor.option("--height-sigma", arguments->options.height_sigma, "m, how well that is known").show_default().range(1e-5, 10.0);
    floor.option("--overlay", arguments->overlay, "picture to write: what was seen, and a grid of metres on the floor");
    add_write_options(floor, arguments->write);
    floor.footer("Example: roomfix calibrate floor site.yaml --camera hall --tile \"310,400 380,402 375,370 312,369\" --tile-size-mm 300 --write");
    floor.on_run([=] { return calibrate_floor_command(*arguments); });
}

void add_calibrate_corner(Command& calibrate) {
    Command corner = calibrate.add_command("corner", "where a fixed camera is, from one corner of the room and its height above the floor");
    auto arguments = std::make_shared<Arguments>();
    corner.option("SITE", arguments->site, "site file").required();
    corner.option("--camera", arguments->camera, "camera that stands still").required();
    corner.option("--corner", arguments->options.corner, "corner of the site that the camera sees").required();
    corner.option("--height", arguments->height, "m, of the camera above the floor").required().range(0.01, 1000.0);
    corner.option("--height-sigma", arguments->options.height_sigma, "m, how well that is known").show_default().range(1e-5, 10.0);
    corner.option("--picture", arguments->picture, "picture without robots (default: the first of the camera's background or source)");
    corner.option("--overlay", arguments->overlay, "picture to write: a grid of metres on the floor");
    add_write_options(corner, arguments->write);
    corner.footer(
        "Example: roomfix calibrate corner site.yaml --camera hall --corner nw --height 2.4 --write\nTogether with points of the floor: calibrate floor "
        "--corner.");
    corner.on_run([=] { return calibrate_floor_command(*arguments); });
}

}  // namespace roomfix
