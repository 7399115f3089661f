#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "calibrate.hpp"
#include "commands.hpp"
#include "roomfix/calibrate/chou1986_calibration.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/site/lens_grid_file.hpp"
#include "roomfix/site/site_text.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string picture, output, corrected, site, camera;
    std::string board = "21x15";
    double square_mm = 30, distance = 1, distance_sigma = 0.005, centre_sigma = 5;
    std::vector<double> centre, wall;
    WriteOptions write;
};

/// Stated, or from a rectangle on a wall along the view, or the picture's middle.
Result<Eigen::Vector2d> centre_of(const Arguments& arguments, LumaView picture) {
    if (!arguments.wall.empty()) {
        const auto& w = arguments.wall;
        const auto centre = image_centre({w[0], w[1]}, {w[2], w[3]}, {w[4], w[5]}, {w[6], w[7]});
        if (!centre) return Error{"--wall: the two sides are parallel in the picture: the wall must run along the view"};
        fmt::print("image centre: ({:.2f}, {:.2f}) px, where the sides of the rectangle meet\n", centre->x(), centre->y());
        return *centre;
    }
    if (!arguments.centre.empty()) return Eigen::Vector2d(arguments.centre[0], arguments.centre[1]);
    return Eigen::Vector2d(0.5 * (picture.width - 1), 0.5 * (picture.height - 1));
}

int calibrate_grid_command(const Arguments& arguments) {
    const auto picture = load_luma(arguments.picture);
    if (!picture) return give_up(picture.error());
    const auto given = parse_board(arguments.board, arguments.square_mm);
    if (!given) return give_up(given.error());
    const Chessboard& board = *given;
    const BoardShot shot = find_chessboard(*picture, board, arguments.picture);
    if (!shot.refused.empty()) return give_up(Error{fmt::format("{}: {}; all of it must be in the picture", arguments.picture, shot.refused)});
    if (!shot.numbers.empty()) {
        return give_up(
            Error{fmt::format("{}: only {} of {} corners can be read, and the grid needs all of them: is there glare, or something before the board?",
                              arguments.picture, shot.corners.size(), board.corners())});
    }
    const auto centre = centre_of(arguments, *picture);
    if (!centre) return give_up(centre.error());
    const auto ideal = ideal_grid(shot.corners, board, *centre);
    if (!ideal) return give_up(ideal.error());
    const auto grid = LensGrid::create(board.columns, shot.corners, ideal->points);
    if (!grid) return give_up(grid.error());
    const double focal = *focal_length(ideal->spacing, arguments.distance, board.square);
    double moved = 0;
    for (std::size_t i = 0; i < shot.corners.size(); ++i) moved = std::max(moved, (shot.corners[i] - ideal->points[i]).norm());
    fmt::print("focal length: {:.2f} +- {:.2f} px ({:.3f} px between points {:.1f} mm apart, {:.3f} m away)\n", focal,
               focal * arguments.distance_sigma / arguments.distance, ideal->spacing, arguments.square_mm, arguments.distance);
    fmt::print("grid: {} points, moved by up to {:.1f} px\n", shot.corners.size(), moved);
    if (!write_file(arguments.output, lens_grid_text(*grid))) return failed;
    if (!arguments.corrected.empty()) {
        LumaImage corrected;
        correct_picture(*picture, *grid, corrected);
        if (auto saved = save_luma(arguments.corrected, corrected); !saved) return give_up(saved.error());
    }
    const CameraModel model = make_camera_model(picture->width(), picture->height(), focal, focal, centre->x(), centre->y());
    const IntrinsicsMatrix covariance = published_covariance(focal, arguments.distance, arguments.distance_sigma, arguments.centre_sigma);
    std::string file = arguments.output;
    Quality quality{.what = "px expected error over the picture"};
    if (!arguments.site.empty()) {
        const auto known = load_camera(arguments.site, arguments.camera);
        if (!known) return give_up(known.error());
        quality = lens_quality(known->camera, model, covariance);
        file = std::filesystem::relative(arguments.output, std::filesystem::path(arguments.site).parent_path()).string();
    }
    if (arguments.write.write && arguments.site.empty()) return give_up(Error{"--write needs --site and --camera"});
    return write_or_show(arguments.site, arguments.camera,
                         {{"intrinsics", intrinsics_text(model, covariance)}, {"distortion_model", ""}, {"distortion", ""}, {"lens_grid", file}}, quality,
                         arguments.write);
}

}  // namespace

void add_calibrate_grid(Command& calibrate) {
    Command grid = calibrate.add_command("grid", "any lens, as Chou and Tsai 1986 do it: one picture of a chessboard that fills the view, parallel to it");
    auto arguments = std::make_shared<Arguments>();
    grid.option("PICTURE", arguments->picture, "picture of the board").required();
    grid.option("--board", arguments->board, "its inner corners, across x down").show_default();
    grid.option("--square-mm", arguments->square_mm, "edge of a square, mm").show_default().range(0.1, 10000.0);
    grid.option("--distance", arguments->distance, "m, from the lens to the board").required().range(0.01, 1000.0);
    grid.option("--distance-sigma", arguments->distance_sigma, "m, how well that is known").show_default().range(0.0, 10.0);
    grid.option("--centre-sigma", arguments->centre_sigma, "px, how well the image centre is known, each coordinate").show_default().range(0.01, 1000.0);
    grid.numbers("--centre", arguments->centre, 2, "image centre, px: U V (default: the picture's middle)");
    grid.numbers("--wall", arguments->wall, 8,
                 "image centre from a rectangle on a wall along the view: two pixels of its upper side, two of its lower: U V U V U V U V");
    grid.option("-o,--output", arguments->output, "CSV file to write, for the site file's key lens_grid").required();
    grid.option("--corrected", arguments->corrected, "picture to write: this one as a lens without distortion would show it");
    CommandOption site = grid.option("--site", arguments->site, "site file");
    grid.option("--camera", arguments->camera, "camera of the site file").needs(site);
    add_write_options(grid, arguments->write);
    grid.footer("Example: roomfix calibrate grid board.png --board 21x15 --square-mm 30 --distance 0.8 -o hall-lens.csv");
    grid.on_run([=] { return calibrate_grid_command(*arguments); });
}

}  // namespace roomfix
