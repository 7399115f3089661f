#include "roomfix/connect/body_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "roomfix/site/body_parts.hpp"

namespace roomfix {
namespace {

constexpr int tile = 260;   // px, edge of one view
constexpr int margin = 24;  // px, around the body
constexpr double dark = 6;  // grey levels, of the log colours (EvidenceSettings::dark)

struct Side {
    const char* name;
    Eigen::Vector3d right, up, towards;  // of the picture, in the robot frame; towards the viewer
};

/// The spots as discs of their colours, those behind drawn first; without a look the parts' corners.
void draw_side(cv::Mat& picture, const LearnedBody& body, const Side& side, double scale, const Eigen::Vector3d& middle) {
    const auto place = [&](const Eigen::Vector3d& p) {
        const Eigen::Vector3d d = p - middle;
        return cv::Point(static_cast<int>(std::lround(tile / 2 + scale * d.dot(side.right))), static_cast<int>(std::lround(tile / 2 - scale * d.dot(side.up))));
    };
    for (const ConvexPart& part : body.parts) {
        std::vector<cv::Point> points;
        for (const auto& p : part.points) points.push_back(place(p));
        std::vector<cv::Point> hull;
        cv::convexHull(points, hull);
        cv::fillConvexPoly(picture, hull, {205, 205, 205}, cv::LINE_AA);
    }
    std::vector<const LookSpot*> seen;
    for (const LookSpot& spot : body.look.spots) {
        if (spot.outwards.cast<double>().dot(side.towards) > 0.3) seen.push_back(&spot);
    }
    std::sort(seen.begin(), seen.end(),
              [&](const LookSpot* a, const LookSpot* b) { return a->place.cast<double>().dot(side.towards) < b->place.cast<double>().dot(side.towards); });
    const double apart = body.look.spots.size() > 1 ? (body.look.spots[1].place - body.look.spots[0].place).cast<double>().norm() : 0.02;
    const int radius = std::clamp(static_cast<int>(0.6 * scale * apart), 2, 12);
    for (const LookSpot* spot : seen) {
        cv::Scalar colour;
        for (int k = 0; k < 3; ++k) colour[k] = std::exp(static_cast<double>(spot->colour[static_cast<std::size_t>(body.look.channels == 3 ? k : 0)])) - dark;
        const cv::Point p = place(spot->place.cast<double>());
        cv::rectangle(picture, p - cv::Point(radius, radius), p + cv::Point(radius, radius), colour, cv::FILLED);
    }
    cv::putText(picture, side.name, {6, 16}, cv::FONT_HERSHEY_SIMPLEX, 0.45, {60, 60, 60}, 1, cv::LINE_AA);
}

}  // namespace

Result<void> save_body_picture(const std::filesystem::path& file, const LearnedBody& body) {
    const Box box = box_around(body.parts);
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
    const std::vector<Side> sides = {{"from the front", y, z, x},
                                     {"from the left", -x, z, y},
                                     {"from the back", -y, z, -x},
                                     {"from the right", x, z, -y},
                                     {"from above: front is up", -y, x, z}};
    const double scale = (tile - 2 * margin) / std::max({box.length, box.width, box.height, 1e-3});
    cv::Mat picture(tile + 26, tile * static_cast<int>(sides.size()), CV_8UC3, cv::Scalar(240, 240, 240));
    for (std::size_t i = 0; i < sides.size(); ++i) {
        cv::Mat part = picture(cv::Rect(tile * static_cast<int>(i), 0, tile, tile));
        draw_side(part, body, sides[i], scale, {0, 0, box.height / 2});
    }
    const std::string text = fmt::format("{:.2f} x {:.2f} x {:.2f} m (+- {:.3f}), {} spots, {}", box.length, box.width, box.height, body.size_sigma,
                                         body.look.spots.size(), body.symmetry == 0 ? "no direction" : "has a front");
    cv::putText(picture, text, {6, tile + 18}, cv::FONT_HERSHEY_SIMPLEX, 0.45, {60, 60, 60}, 1, cv::LINE_AA);
    bool written = false;
    try {
        written = cv::imwrite(file.string(), picture);
    } catch (const cv::Exception&) {  // the ending names no kind of picture
    }
    if (!written) return Error{fmt::format("{}: cannot be written: give a folder that exists and an ending such as .png", file.string())};
    return {};
}

}  // namespace roomfix
