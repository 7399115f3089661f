#include "roomfix/calibrate/lens_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "roomfix/base/html.hpp"

namespace roomfix {
namespace {

std::vector<std::string> names_of(Distortion kind) {
    std::vector<std::string> names = {"fx", "fy", "cx", "cy"};
    static constexpr std::array plumb_bob = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
    static constexpr std::array equidistant = {"k1", "k2", "k3", "k4"};
    for (int i = 0; i < distortion_count(kind); ++i) {
        names.emplace_back(kind == Distortion::equidistant ? equidistant[static_cast<std::size_t>(i)] : plumb_bob[static_cast<std::size_t>(i)]);
    }
    return names;
}

/// Pixels of a grid over the picture, cell by cell, row by row.
Eigen::Matrix<double, 2, Eigen::Dynamic> cells(const CameraModel& model, int across, int down) {
    Eigen::Matrix<double, 2, Eigen::Dynamic> pixels(2, across * down);
    for (int i = 0; i < across * down; ++i) pixels.col(i) << (i % across + 0.5) * model.width / across - 0.5, (i / across + 0.5) * model.height / down - 0.5;
    return pixels;
}

std::string frame(const CameraModel& model, const std::string& inside, const std::string& label) {
    return fmt::format(
        "<svg viewBox=\"-2 -2 {} {}\" width=\"480\" role=\"img\" aria-label=\"{}\"><rect width=\"{}\" height=\"{}\" fill=\"#f6f6f4\" stroke=\"#999\"/>{}</svg>",
        model.width + 4, model.height + 4, label, model.width, model.height, inside);
}

/// Where corners were seen; the boards' outlines.
std::string coverage_picture(const LensCalibration& lens, const Chessboard& board) {
    std::string dots;
    for (const BoardShot& shot : lens.shots) {
        if (shot.corners.empty()) continue;
        const bool good = shot.refused.empty();
        if (shot.numbers.empty()) {  // the whole board
            const auto at = [&](int i) { return shot.corners[static_cast<std::size_t>(i)]; };
            const Eigen::Vector2d a = at(0), b = at(board.columns - 1), c = at(board.corners() - 1), d = at(board.corners() - board.columns);
            dots +=
                fmt::format("<polygon points=\"{:.0f},{:.0f} {:.0f},{:.0f} {:.0f},{:.0f} {:.0f},{:.0f}\" fill=\"none\" stroke=\"{}\" stroke-opacity=\"0.5\"/>",
                            a.x(), a.y(), b.x(), b.y(), c.x(), c.y(), d.x(), d.y(), good ? "#1f6fb2" : "#b3323f");
        }
        if (!good) continue;
        for (const Eigen::Vector2d& p : shot.corners)
            dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"#1f6fb2\"/>", p.x(), p.y(), 0.003 * lens.model.width);
    }
    return frame(lens.model, dots, "where corners were seen");
}

/// Residuals where they are, a hundred times as long.
std::string residual_picture(const LensCalibration& lens) {
    constexpr double enlarged = 100;
    std::string lines;
    for (std::size_t s = 0; s < lens.shots.size(); ++s) {
        for (std::size_t i = 0; i < lens.residuals[s].size(); ++i) {
            const Eigen::Vector2d p = lens.shots[s].corners[i], r = enlarged * lens.residuals[s][i];
            lines += fmt::format("<path d=\"M{:.1f} {:.1f}l{:.1f} {:.1f}\" stroke=\"#c2571a\" stroke-width=\"{:.2f}\"/>", p.x(), p.y(), r.x(), r.y(),
                                 0.0016 * lens.model.width);
        }
    }
    return frame(lens.model, lines, "residuals");
}

std::string heat(double part) {
    part = std::clamp(part, 0.0, 1.0);
    // From pale yellow over orange to dark red.
    const double r = 255 - 110 * part * part, g = 247 - 205 * part, b = 215 - 190 * std::sqrt(part);
    return fmt::format("rgb({:.0f},{:.0f},{:.0f})", r, g, b);
}

/// -1: blue, low; 0: pale; 1: red, high.
std::string height_colour(double part) {
    part = std::clamp(part, -1.0, 1.0);
    const double pale = 1 - std::abs(part);
    const Eigen::Vector3d end = part > 0 ? Eigen::Vector3d(178, 60, 40) : Eigen::Vector3d(40, 90, 170);
    const Eigen::Vector3d colour = pale * Eigen::Vector3d(238, 236, 228) + (1 - pale) * end;
    return fmt::format("rgb({:.0f},{:.0f},{:.0f})", colour.x(), colour.y(), colour.z());
}

struct ErrorMap {
    std::string picture;
    double least = 0, mean = 0, largest = 0;
};

ErrorMap error_map(const LensCalibration& lens) {
    constexpr int across = 24, down = 18;
    const Eigen::VectorXd errors = predicted_error(lens.model, lens.covariance, cells(lens.model, across, down));
    ErrorMap map;
    map.largest = errors.maxCoeff();
    map.least = std::max(errors.minCoeff(), 1e-6);
    const double least = 0.999 * map.least;
    map.mean = std::sqrt(errors.squaredNorm() / static_cast<double>(errors.size()));
    const double w = static_cast<double>(lens.model.width) / across, h = static_cast<double>(lens.model.height) / down;
    std::string inside;
    for (int i = 0; i < across * down; ++i) {
        inside += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"><title>{:.3f} px</title></rect>", i % across * w,
                              i / across * h, w + 0.3, h + 0.3, heat(std::log(errors[i] / least) / std::log(map.largest / least)), errors[i]);
    }
    map.picture = frame(lens.model, inside, "expected error");
    return map;
}

std::string parameter_rows(const LensCalibration& lens) {
    const auto names = names_of(lens.model.kind);
    const IntrinsicsVector numbers = lens.model.intrinsics();
    std::string rows;
    for (std::size_t i = 0; i < names.size(); ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        rows += fmt::format("<tr><td>{}</td><td>{:.5g}</td><td>{:.2g}</td></tr>\n", names[i], numbers[k], std::sqrt(lens.covariance(k, k)));
    }
    return rows;
}

std::string shot_rows(const LensCalibration& lens) {
    std::string rows;
    for (std::size_t i = 0; i < lens.shots.size(); ++i) {
        const BoardShot& s = lens.shots[i];
        const bool good = s.refused.empty();
        const double distance = lens.camera_from_board[i].translation().norm();
        const double tilt = std::acos(std::clamp(std::abs(lens.camera_from_board[i].linear()(2, 2)), 0.0, 1.0));
        rows += fmt::format("<tr{}><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", good ? "" : " class=\"off\"", html_escaped(s.name),
                            good ? fmt::format("{:.3f}", lens.shot_rms[i]) : "", s.corners.empty() ? "" : fmt::format("{:.1f}", s.edge_width),
                            good ? fmt::format("{:.2f} m, {:.0f}&deg;", distance, degrees(tilt)) : "", good ? "used" : html_escaped(s.refused));
    }
    return rows;
}

/// The board from in front: where its corners were printed, enlarged, and how high they are, as colours.
std::string board_picture(const LensCalibration& lens) {
    const Chessboard& nominal = lens.board.nominal;
    const Eigen::Vector2d far = nominal.corner(nominal.corners() - 1);
    const double scale = 460 / (far.x() + 2 * nominal.square), margin = scale * nominal.square;
    const double highest = std::max(lens.board.height() * 2.5, 1e-9);
    const double largest = std::max(lens.board.print_error(), 1e-9);
    const Eigen::VectorXd heights = lens.board.heights();
    std::string marks;
    for (int i = 0; i < nominal.corners(); ++i) {
        const Eigen::Vector2d place = nominal.corner(i) * scale + Eigen::Vector2d(margin, margin);
        const Eigen::Vector2d printed_off = lens.board.corner(i).head<2>() - nominal.corner(i);
        const Eigen::Vector2d off = printed_off * 0.3 * margin / largest;
        marks += fmt::format(
            "<circle cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"{2:.1f}\" fill=\"{3}\" fill-opacity=\"0.8\"><title>corner {4}: printed {5:+.3f}, {6:+.3f} mm off, "
            "{7:+.3f} mm "
            "high</title></circle>"
            "<path d=\"M{0:.1f} {1:.1f}l{8:.1f} {9:.1f}\" stroke=\"#222\" stroke-width=\"1.4\"/>",
            place.x(), place.y(), 0.28 * margin, height_colour(heights[i] / highest), i, 1000 * printed_off.x(), 1000 * printed_off.y(), 1000 * heights[i],
            off.x(), off.y());
    }
    const double width = scale * far.x() + 2 * margin, height = scale * far.y() + 2 * margin;
    return fmt::format(
        "<svg viewBox=\"-2 -2 {:.0f} {:.0f}\" width=\"480\" role=\"img\" aria-label=\"the board\"><rect width=\"{:.0f}\" height=\"{:.0f}\" "
        "fill=\"#f6f6f4\" stroke=\"#999\"/>{}</svg>",
        width + 4, height + 4, width, height, marks);
}

/// Worth saying.
bool disagrees(const LensCalibration& lens) { return lens.disagreement > 2; }

/// Half of the focal length's variance or more.
bool board_matters(const LensCalibration& lens) {
    return 2 * lens.focal_sigma_by_board * lens.focal_sigma_by_board > std::min(lens.covariance(0, 0), lens.covariance(1, 1));
}

/// All boards about the same way up: an uneven print then looks like another image centre.
bool one_way_up(const LensCalibration& lens) {
    constexpr double alike = 0.7;  // all within some 45 degrees
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < lens.shots.size(); ++i) {
        if (lens.shots[i].refused.empty()) sum += lens.camera_from_board[i].linear().col(0).head<2>().normalized();
    }
    return !lens.exact_board && sum.norm() > alike * lens.used();
}

/// What other shots would make better.
std::vector<std::string> advice(const LensCalibration& lens) {
    std::vector<std::string> texts;
    if (lens.coverage < 0.7)
        texts.emplace_back("the board was not everywhere in the picture: the expected error is large where it was not; take shots there, too");
    if (one_way_up(lens)) {
        texts.emplace_back(
            "the board was the same way up in all shots: held upside down in half of them, they would tell the image centre about twice as well");
    }
    return texts;
}

}  // namespace

std::string text_of(const LensCalibration& lens) {
    const CameraModel& m = lens.model;
    std::string text = fmt::format("{} of {} shots used, rms {:.3f} px per corner, corners seen in {:.0f} % of the picture\n", lens.used(), lens.shots.size(),
                                   lens.rms, 100 * lens.coverage);
    for (const BoardShot& s : lens.shots) {
        if (!s.refused.empty()) text += fmt::format("  not used: {}: {}\n", s.name, s.refused);
    }
    const auto names = names_of(m.kind);
    const IntrinsicsVector numbers = m.intrinsics();
    for (std::size_t i = 0; i < names.size(); ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        text += fmt::format("  {:3} {:12.5f} +- {:.5f}\n", names[i], numbers[k], std::sqrt(lens.covariance(k, k)));
    }
    if (!lens.exact_board) {
        text += fmt::format(
            "the board, as measured: corners printed {:.3f} mm off, {:.3f} mm out of its plane; moved by {:.2f} mm and {:.2f} deg while a picture was read out "
            "(all "
            "rms)\n",
            1000 * lens.board.print_error(), 1000 * lens.board.height(), 1000 * lens.shift, degrees(lens.turn));
    }
    if (board_matters(lens)) {
        text += fmt::format(
            "the shots show that the board is not as exact as it was taken for: that alone leaves the focal length uncertain by {:.2f} px; without "
            "--exact-board it is measured along\n",
            lens.focal_sigma_by_board);
    }
    const ErrorMap map = error_map(lens);
    text += fmt::format("expected error of a ray: {:.3f} px on average, {:.3f} px at worst\n", map.mean, map.largest);
    if (disagrees(lens)) {
        text += fmt::format(
            "the shots contradict each other more than their corners' noise explains, and all is stated {:.1f} times less sure: did the board or the camera "
            "move?\n",
            std::sqrt(lens.disagreement));
    }
    for (const std::string& what : advice(lens)) text += what + '\n';
    return text;
}

std::string html_of(const LensCalibration& lens, const Chessboard& board, const std::string& title) {
    const ErrorMap map = error_map(lens);
    std::string better;
    for (const std::string& what : advice(lens)) better += fmt::format("<p>Better: {}.</p>\n", what);
    return fmt::format(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title><style>"
        "body{{font:15px/1.5 system-ui,sans-serif;max-width:1040px;margin:2em auto;padding:0 1em;color:#222}}"
        "table{{border-collapse:collapse;font-variant-numeric:tabular-nums}}td,th{{padding:.2em .7em;text-align:right;border-bottom:1px solid #ddd}}"
        "td:first-child,th:first-child,td:last-child,th:last-child{{text-align:left}}.off{{color:#b3323f}}h2{{margin-top:1.6em}}"
        ".pictures{{display:grid;grid-template-columns:repeat(auto-fit,minmax(320px,1fr));gap:1.5em}}svg{{max-width:100%;height:auto}}figure{{margin:0}}"
        "figcaption{{color:#555}}</style></head><body>\n<h1>{0}</h1>\n"
        "<p>{1} x {2} pixels, {3}. {4} of {5} shots used; rms {6:.3f} px per corner; the noise of a corner's coordinate is {7:.3f} px{17}. A ray is expected "
        "to be "
        "off by {8:.3f} px on average and {9:.3f} px at worst.</p>\n{19}<h2>Numbers</h2><table><tr><th></th><th>value</th><th>standard "
        "deviation</th></tr>\n{10}</table>\n"
        "<h2>Pictures</h2><div class=\"pictures\"><figure>{11}<figcaption>Where corners were seen ({12:.0f} % of the picture); red: boards that are not "
        "used.</figcaption>"
        "</figure><figure>{13}<figcaption>Expected error of a ray once the camera's direction is found with this lens: pale is {16:.3f} px, dark {9:.3f} "
        "px.</figcaption></figure>"
        "<figure>{14}<figcaption>Residuals, a hundred times as long. They should look like noise; a pattern means that the lens is of another kind."
        "</figcaption></figure>{18}</div>\n<h2>Shots</h2><table><tr><th>picture</th><th>rms px</th><th>edges "
        "px</th><th>board</th><th></th></tr>\n{15}</table>\n</body></html>\n",
        html_escaped(title), lens.model.width, lens.model.height, name_of(lens.model.kind), lens.used(), lens.shots.size(), lens.rms, lens.sigma, map.mean,
        map.largest, parameter_rows(lens), coverage_picture(lens, board), 100 * lens.coverage, map.picture, residual_picture(lens), shot_rows(lens), map.least,
        disagrees(lens)
            ? fmt::format(
                  "; shots contradict each other more than that explains (did the board or the camera move?), so that all is stated {:.1f} times less sure",
                  std::sqrt(lens.disagreement))
            : "",
        lens.exact_board
            ? ""
            : fmt::format("<figure>{}<figcaption>The board, measured along with the lens: lines show where corners were printed (rms {:.3f} mm), colours "
                          "how high they are (red) or low (blue; rms {:.3f} mm). It moved by {:.2f} mm and {:.2f}&deg; while a picture was read "
                          "out.</figcaption></figure>",
                          board_picture(lens), 1000 * lens.board.print_error(), 1000 * lens.board.height(), 1000 * lens.shift, degrees(lens.turn)),
        better);
}

}  // namespace roomfix
