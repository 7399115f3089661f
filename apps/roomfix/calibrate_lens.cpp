#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "calibrate.hpp"
#include "commands.hpp"
#include "roomfix/calibrate/lens_report.hpp"
#include "roomfix/connect/camera_info.hpp"
#include "roomfix/connect/frame_source.hpp"
#include "roomfix/site/site_text.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::vector<std::string> pictures;
    std::string board = "9x6";
    double square_mm = 25;
    std::string markers;
    double marker_mm = 0;
    bool exact_board = false;
    std::string model = "plumb_bob";
    std::string report, camera_info, from, print_board;
    std::string site, camera;
    WriteOptions write;
};

/// Where no picture shows the board, perhaps they show one of another size.
Result<void> check_board(const std::vector<BoardShot>& shots, const LumaImage& picture, const Chessboard& board) {
    const bool found = std::any_of(shots.begin(), shots.end(), [](const BoardShot& s) { return !s.corners.empty(); });
    if (found || picture.empty() || board.markers) return {};
    const auto other = other_board_in(picture, board);
    if (!other) return {};
    return Error{fmt::format("no board with {}x{} inner corners, but one with {}x{}: give --board {}x{}", board.columns, board.rows, other->columns,
                             other->rows, other->columns, other->rows)};
}

/// All pictures of files, folders and videos.
Result<std::vector<BoardShot>> shots_of(const Arguments& arguments, const Chessboard& board, int& width, int& height) {
    constexpr std::size_t soon = 2;  // pictures without a board after which another size is looked for: it would not be found in the others, either
    std::vector<BoardShot> shots;
    const auto progress = progress_bar("looking for the board");
    for (std::size_t i = 0; i < arguments.pictures.size(); ++i) {
        auto source = open_source(arguments.pictures[i]);
        if (!source) return source.error();
        if ((*source)->live()) return Error{arguments.pictures[i] + ": take pictures first; a live camera has no end"};
        SourceFrame frame;
        for (;;) {
            const auto more = (*source)->next(frame);
            if (!more) {
                shots.push_back({arguments.pictures[i], {}, 0, 0, more.error().message});
                continue;
            }
            if (!*more) break;
            if (width == 0) width = frame.image.width(), height = frame.image.height();
            if (frame.image.width() != width || frame.image.height() != height) {
                return Error{fmt::format("{} is {} x {} pixels, the pictures before it are {} x {}: calibrate one resolution at a time", frame.name,
                                         frame.image.width(), frame.image.height(), width, height)};
            }
            shots.push_back(find_board(frame.image, board, frame.name));
            if (shots.size() != soon) continue;
            if (auto checked = check_board(shots, frame.image, board); !checked) return checked.error();
        }
        progress(static_cast<double>(i + 1) / static_cast<double>(arguments.pictures.size()));
    }
    return shots;
}

/// Puts a lens into the site file, or prints it. `camera` of the site file; null: none was named.
int give_to_site(const Arguments& arguments, const SiteCamera* camera, const CameraModel& found, const IntrinsicsMatrix& covariance) {
    CameraModel model = found;
    IntrinsicsMatrix known = covariance;
    Quality quality{.what = "px expected error over the picture"};
    if (camera) {
        if (camera->model.width != model.width || camera->model.height != model.height) {
            const auto scaled = rescaled(model, camera->model.width, camera->model.height);
            if (!scaled) {
                return give_up(
                    Error{fmt::format("the calibration is for {} x {} pixels, camera {} has {} x {}: another shape, so another part of the picture; "
                                      "calibrate at the camera's own resolution",
                                      model.width, model.height, camera->id, camera->model.width, camera->model.height)});
            }
            known = rescaled(covariance, model, *scaled);
            say(fmt::format("scaled from {} x {} to the camera's {} x {} pixels", model.width, model.height, scaled->width, scaled->height));
            model = *scaled;
        }
        quality = lens_quality(*camera, model, known);
    }
    const std::string kind = model.kind == Distortion::plumb_bob ? "" : name_of(model.kind);
    return write_or_show(arguments.site, arguments.camera,
                         {{"intrinsics", intrinsics_text(model, known)}, {"distortion_model", kind}, {"distortion", distortion_text(model)}, {"lens_grid", ""}},
                         quality, arguments.write);
}

int calibrate_lens_command(const Arguments& arguments) {
    const auto board = parse_board(arguments.board, arguments.square_mm, arguments.markers, arguments.marker_mm);
    if (!board) return give_up(board.error());
    if (!arguments.print_board.empty()) {
        if (!write_file(arguments.print_board, board_svg(*board))) return failed;
        say(fmt::format("{}: print it at 100 %, check the ruler, and glue it onto something flat", arguments.print_board));
        if (arguments.pictures.empty()) return done;
    }
    if (arguments.write.write && arguments.site.empty()) return give_up(Error{"--write needs --site and --camera"});
    std::optional<SiteCamera> camera;
    if (!arguments.site.empty()) {
        const auto found_in = load_camera(arguments.site, arguments.camera);
        if (!found_in) return give_up(found_in.error());
        camera = found_in->camera;
    }
    const SiteCamera* given_to = camera ? &*camera : nullptr;
    if (!arguments.from.empty()) {
        const auto info = load_camera_info(arguments.from);
        if (!info) return give_up(info.error());
        return give_to_site(arguments, given_to, info->model, IntrinsicsMatrix::Zero());
    }
    if (arguments.pictures.empty()) return give_up(Error{"no pictures: give files, a folder or a video of the board, or --from a camera_info file"});
    int width = 0, height = 0;
    auto shots = shots_of(arguments, *board, width, height);
    if (!shots) return give_up(shots.error());
    const auto lens =
        calibrate_lens(std::move(*shots), width, height, *board, {.kind = *distortion_named(arguments.model), .exact_board = arguments.exact_board});
    if (!lens) return give_up(lens.error());
    fmt::print("{}", text_of(*lens));
    const std::string name = arguments.camera.empty() ? "camera" : arguments.camera;
    if (!arguments.report.empty()) {
        if (!write_file(arguments.report, html_of(*lens, *board, "Lens of " + name))) return failed;
        say("report: " + arguments.report);
    }
    if (!arguments.camera_info.empty() && !write_file(arguments.camera_info, camera_info_text({name, lens->model}))) return failed;
    return give_to_site(arguments, given_to, lens->model, lens->covariance);
}

}  // namespace

void add_calibrate_lens(Command& calibrate) {
    Command lens = calibrate.add_command("lens", "focal length, image centre and distortion, from pictures of a chessboard or a ChArUco board");
    auto arguments = std::make_shared<Arguments>();
    lens.option("PICTURES", arguments->pictures, "pictures, folders or videos of the board");
    lens.option("--board", arguments->board, "its inner corners, across x down").show_default();
    lens.option("--square-mm", arguments->square_mm, "edge of a square, mm").show_default().range(0.1, 10000.0);
    CommandOption marker = lens.option("--marker-mm", arguments->marker_mm, "edge of a marker with its black border, mm").range(0.1, 10000.0);
    lens.option("--charuco", arguments->markers, "the board has markers of this dictionary in its white squares: DICT_4X4_50, DICT_5X5_250, ...").needs(marker);
    lens.flag("--exact-board", arguments->exact_board, "the board is a screen or an engraved plate: its shape is not measured along with the lens");
    lens.option("--model", arguments->model, "kind of lens").show_default().one_of({"plumb_bob", "rational_polynomial", "equidistant"});
    lens.option("--report", arguments->report, "page to write: numbers, shots, coverage, expected error");
    lens.option("--camera-info", arguments->camera_info, "file to write, as ROS reads it");
    lens.option("--from", arguments->from, "take the lens from a camera_info file of ROS or a file of OpenCV instead of pictures");
    lens.option("--print-board", arguments->print_board, "SVG file to write: the board, with a ruler");
    CommandOption site = lens.option("--site", arguments->site, "site file");
    lens.option("--camera", arguments->camera, "camera of the site file").needs(site);
    add_write_options(lens, arguments->write);
    lens.footer("Example: roomfix calibrate lens --print-board board.svg   ...then:   roomfix calibrate lens pictures/ --square-mm 25 --report lens.html");
    lens.on_run([=] { return calibrate_lens_command(*arguments); });
}

}  // namespace roomfix
