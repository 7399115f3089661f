#include "roomfix/connect/overlay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace roomfix {
namespace {

const cv::Scalar outline_colour(80, 200, 60);  // BGR
const cv::Scalar heading_colour(40, 140, 255);
const cv::Scalar lamp_colour(60, 80, 230);

/// Writes labels above boxes (sixteenths of a pixel), on a dark ground, inside the picture and not over each other.
class LabelWriter {
public:
    void write_above(cv::Mat& picture, const cv::Rect& box, const std::string& label) {
        constexpr double size = 0.38;
        int below = 0;
        const cv::Size text = cv::getTextSize(label, cv::FONT_HERSHEY_SIMPLEX, size, 1, &below);
        const int left = std::clamp((box.x + box.width / 2) / 16 - text.width / 2, 2, std::max(picture.cols - text.width - 2, 2));
        const int bottom = std::max(box.y / 16 - 5, text.height + 3);
        cv::Rect ground(left - 2, bottom - text.height - 2, text.width + 4, text.height + below + 2);
        const auto covers_another = [&] {
            return std::any_of(written_.begin(), written_.end(), [&](const cv::Rect& other) { return (other & ground).area() > 0; });
        };
        while (covers_another() && ground.y > ground.height) ground.y -= ground.height + 1;
        written_.push_back(ground);
        cv::rectangle(picture, ground, {40, 40, 40}, cv::FILLED);
        cv::putText(picture, label, {left, ground.y + text.height + 2}, cv::FONT_HERSHEY_SIMPLEX, size, {255, 255, 255}, 1, cv::LINE_AA);
    }

private:
    std::vector<cv::Rect> written_;
};

/// A picture to draw on, `zoom` times as large as the frame, in colour.
struct Enlarged {
    cv::Mat picture;
    double zoom = 1;

    /// Where a point of the frame (px, the centre of the first pixel at 0) is drawn, sixteenths of a pixel.
    cv::Point place(const Eigen::Vector2d& p) const {
        const Eigen::Vector2d at = 16 * ((p.array() + 0.5) * zoom - 0.5);
        return {static_cast<int>(at.x()), static_cast<int>(at.y())};
    }
    cv::Point place(const Eigen::Vector2f& p) const { return place(Eigen::Vector2d(p.cast<double>())); }
    cv::Point place(double x, double y) const { return place(Eigen::Vector2d(x, y)); }
};

cv::Mat in_colour(LumaView frame) {
    const cv::Mat grey(frame.height, frame.width, CV_8UC1, const_cast<std::uint8_t*>(frame.data), static_cast<std::size_t>(frame.stride));
    cv::Mat picture;
    cv::cvtColor(grey, picture, cv::COLOR_GRAY2BGR);
    return picture;
}

/// Small pictures twice as large.
Enlarged enlarged(LumaView frame) {
    Enlarged large{.picture = {}, .zoom = frame.width < 1000 ? 2.0 : 1.0};
    cv::resize(in_colour(frame), large.picture, {}, large.zoom, large.zoom, cv::INTER_LINEAR);
    return large;
}

/// Along the lower edge.
void write_caption(cv::Mat& picture, const std::string& caption) {
    if (caption.empty()) return;
    cv::rectangle(picture, cv::Rect(0, picture.rows - 18, picture.cols, 18), {40, 40, 40}, cv::FILLED);
    cv::putText(picture, caption, {6, picture.rows - 5}, cv::FONT_HERSHEY_SIMPLEX, 0.4, {255, 255, 255}, 1, cv::LINE_AA);
}

Result<void> save(const std::filesystem::path& file, const cv::Mat& picture) {
    try {
        if (cv::imwrite(file.string(), picture)) return {};
    } catch (const cv::Exception&) {  // no such format
    }
    return Error{fmt::format("{}: the overlay cannot be written: check the folder, and use .png or .jpg", file.string())};
}

void draw_outline(Enlarged& large, const DrawnOutline& outline, LabelWriter& labels) {
    std::vector<cv::Point> polygon;
    for (const Eigen::Vector2f& point : outline.points) polygon.push_back(large.place(point));
    cv::polylines(large.picture, polygon, true, outline_colour, 1, cv::LINE_AA, 4);
    if (outline.foot && outline.ahead) {
        cv::arrowedLine(large.picture, large.place(*outline.foot), large.place(*outline.ahead), heading_colour, 2, cv::LINE_AA, 4, 0.25);
    }
    if (outline.foot) cv::circle(large.picture, large.place(*outline.foot), 3 * 16, heading_colour, cv::FILLED, cv::LINE_AA, 4);
    if (!outline.label.empty()) labels.write_above(large.picture, cv::boundingRect(polygon), outline.label);
}

void draw_landmark(Enlarged& large, const DrawnLandmark& landmark, LabelWriter& labels) {
    std::vector<cv::Point> polygon;
    for (const Eigen::Vector2f& point : landmark.points) {
        polygon.push_back(large.place(point));
        cv::circle(large.picture, polygon.back(), 5 * 16, outline_colour, 1, cv::LINE_AA, 4);
    }
    cv::polylines(large.picture, polygon, true, outline_colour, 1, cv::LINE_AA, 4);
    const std::string& label = landmark.id.empty() ? landmark.label : landmark.id;
    if (!label.empty()) labels.write_above(large.picture, cv::boundingRect(polygon), label);
}

void draw_corner(Enlarged& large, const DrawnCorner& corner, LabelWriter& labels) {
    for (std::size_t e = 0; e < corner.edges.size(); ++e) {
        const DrawnLine& edge = corner.edges[e];
        const bool between_walls = e + 1 == corner.edges.size();
        cv::line(large.picture, large.place(edge.from), large.place(edge.to), between_walls ? heading_colour : outline_colour, 2, cv::LINE_AA, 4);
    }
    const cv::Point middle = large.place(corner.pixel);
    cv::circle(large.picture, middle, 5 * 16, {255, 255, 255}, 1, cv::LINE_AA, 4);
    if (!corner.id.empty()) labels.write_above(large.picture, cv::Rect(middle.x, middle.y - 8 * 16, 1, 1), corner.id);
}

void draw_rejected(Enlarged& large, const Drawing& drawing) {
    cv::Mat faint = large.picture.clone();
    for (const DrawnLine& line : drawing.rejected_lines) cv::line(faint, large.place(line.from), large.place(line.to), lamp_colour, 1, cv::LINE_AA, 4);
    cv::addWeighted(faint, 0.35, large.picture, 0.65, 0, large.picture);
    for (const auto& [left, top, right, bottom] : drawing.lamps) {
        cv::rectangle(large.picture, large.place(left - 2, top - 2), large.place(right + 2, bottom + 2), lamp_colour, 1, cv::LINE_AA, 4);
    }
    for (const Eigen::Vector2f& spot : drawing.rejected_spots) {
        const double x = static_cast<double>(spot.x());
        const double y = static_cast<double>(spot.y());
        cv::line(large.picture, large.place(x - 4, y - 4), large.place(x + 4, y + 4), lamp_colour, 1, cv::LINE_AA, 4);
        cv::line(large.picture, large.place(x - 4, y + 4), large.place(x + 4, y - 4), lamp_colour, 1, cv::LINE_AA, 4);
    }
}

}  // namespace

Result<void> save_overlay(const std::filesystem::path& file, LumaView frame, const Drawing& drawing) {
    Enlarged large = enlarged(frame);
    LabelWriter labels;
    draw_rejected(large, drawing);
    for (const DrawnOutline& outline : drawing.outlines) draw_outline(large, outline, labels);
    for (const DrawnLandmark& landmark : drawing.landmarks) draw_landmark(large, landmark, labels);
    if (drawing.corner) draw_corner(large, *drawing.corner, labels);
    write_caption(large.picture, drawing.caption);
    return save(file, large.picture);
}

Result<void> save_floor_overlay(const std::filesystem::path& file, LumaView frame, const View& view, const std::vector<Eigen::Vector2d>& seen) {
    Enlarged large = enlarged(frame);
    const auto line = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to, const cv::Scalar& colour, int thick) {
        constexpr int pieces = 8;  // lenses bend straight lines
        for (int i = 0; i < pieces; ++i) {
            const Eigen::Vector2d a = from + (to - from) * i / pieces, b = from + (to - from) * (i + 1) / pieces;
            const auto p = project_map_point(view, {a.x(), a.y(), 0}), q = project_map_point(view, {b.x(), b.y(), 0});
            if (p && q && (view.model.contains(*p, -50) || view.model.contains(*q, -50)))
                cv::line(large.picture, large.place(*p), large.place(*q), colour, thick, cv::LINE_AA, 4);
        }
    };
    const int reach = static_cast<int>(std::ceil(8 * view.position().z()));
    const Eigen::Vector2i here = view.position().head<2>().array().round().matrix().cast<int>();
    const cv::Mat bare = large.picture.clone();
    for (int x = here.x() - reach; x <= here.x() + reach; ++x) {
        for (int y = here.y() - reach; y <= here.y() + reach; ++y) {
            line({x, y}, {x + 1, y}, outline_colour, 1);
            line({x, y}, {x, y + 1}, outline_colour, 1);
        }
    }
    cv::addWeighted(large.picture, 0.6, bare, 0.4, 0, large.picture);
    for (const Eigen::Vector2d& p : seen) cv::circle(large.picture, large.place(p), 16 * 3 / 2, lamp_colour, cv::FILLED, cv::LINE_AA, 4);
    line({0, 0}, {1, 0}, heading_colour, 2);
    line({0, 0}, {0, 1}, heading_colour, 2);
    write_caption(large.picture, "green: a grid of metres; red: what the calibration rests on; orange: the map's axes from its origin");
    return save(file, large.picture);
}

Result<void> save_edges_overlay(const std::filesystem::path& file, LumaView frame, const std::vector<std::vector<Eigen::Vector2d>>& straight,
                                const std::vector<std::vector<Eigen::Vector2d>>& others) {
    Enlarged large = enlarged(frame);
    const auto draw = [&](const std::vector<std::vector<Eigen::Vector2d>>& edges, const cv::Scalar& colour) {
        for (const auto& edge : edges) {
            std::vector<cv::Point> line;
            for (const Eigen::Vector2d& p : edge) line.push_back(large.place(p));
            cv::polylines(large.picture, line, false, colour, 2, cv::LINE_AA, 4);
        }
    };
    draw(others, lamp_colour);
    draw(straight, outline_colour);
    write_caption(large.picture, "green: edges that the calibration makes straight; red: left out");
    return save(file, large.picture);
}

}  // namespace roomfix
