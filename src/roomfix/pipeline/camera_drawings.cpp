// What a camera saw, as the page draws it into the picture. Documented in docs/formats.md.
#include <nlohmann/json.hpp>

#include "roomfix/ceiling/lamps.hpp"
#include "roomfix/pipeline/camera_pipeline.hpp"
#include "roomfix/pipeline/page_numbers.hpp"

namespace roomfix {
namespace {

using nlohmann::json;

json pixel(double u, double v) { return {rounded(u, 0.1), rounded(v, 0.1)}; }

}  // namespace

/// Landmarks with their points, spots that are none, lamps.
json CameraPipeline::landmark_drawing(const ShownFrame& shown) const {
    json seen = {{"landmarks", json::array()}, {"rejected", json::array()}, {"lamps", json::array()}};
    const auto names = locator_->landmark_names(shown.onboard);
    for (std::size_t i = 0; i < names.size(); ++i) {
        json points = json::array();
        for (const auto& p : shown.onboard.seen.landmarks[i].points) points.push_back(pixel(p.pixel.x(), p.pixel.y()));
        seen["landmarks"].push_back({{"id", names[i].empty() ? json() : json(names[i])}, {"points", points}});
    }
    for (const auto& spot : shown.onboard.seen.rejected) {
        seen["rejected"].push_back(pixel(static_cast<double>(spot.pixel.x()), static_cast<double>(spot.pixel.y())));
    }
    if (!shown.picture.empty()) {
        for (const LampBox& lamp : find_lamps(shown.picture)) seen["lamps"].push_back({lamp.left, lamp.top, lamp.right, lamp.bottom});
    }
    return seen;
}

/// Tags with their corners, as landmarks.
json CameraPipeline::tag_drawing(const ShownFrame& shown) const {
    json seen = {{"landmarks", json::array()}, {"rejected", json::array()}, {"lamps", json::array()}};
    for (const SeenTag& tag : shown.by_tags.seen) {
        json points = json::array();
        for (const Eigen::Vector2d& corner : tag.corners) points.push_back(pixel(corner.x(), corner.y()));
        const std::string name = tag_camera_->name_of_tag(tag);
        seen["landmarks"].push_back({{"id", name.empty() ? json() : json(name)}, {"points", points}});
    }
    return seen;
}

/// The corner's edges, with the walls' last, and lines that are none of them.
json CameraPipeline::corner_drawing(const ShownFrame& shown) const {
    json seen = {{"id", json()}, {"edges", json::array()}, {"rejected", json::array()}};
    const auto segment = [](const Eigen::Vector2f& from, const Eigen::Vector2f& to) {
        json line = json::array();
        for (const float v : {from.x(), from.y(), to.x(), to.y()}) line.push_back(rounded(static_cast<double>(v), 0.1));
        return line;
    };
    for (const RejectedLine& line : shown.corner.seen.rejected) seen["rejected"].push_back(segment(line.from, line.to));
    if (shown.corner.seen.corners.empty()) return seen;
    const bool placed = !shown.corner.located.places.empty();
    const CornerObservation& corner = shown.corner.seen.corners[placed ? static_cast<std::size_t>(shown.corner.located.places[0].observation) : 0];
    if (placed && shown.corner.located.best_corner > likely) seen["id"] = corners_->corner_name(shown.corner);
    for (const EdgeSighting& edge : corner.edges) seen["edges"].push_back(segment(edge.ends[0], edge.ends[1]));
    return seen;
}

void CameraPipeline::add_drawings(const ShownFrame& shown, json& state) const {
    state["outlines"] = json::array();
    for (const SilhouetteObservation& o : shown.outlines) {
        json outline = json::array();
        for (const auto& corner : o.outline) outline.push_back(pixel(static_cast<double>(corner.x()), static_cast<double>(corner.y())));
        const std::string robot = robots_[static_cast<std::size_t>(o.robot)].id;
        state["outlines"].push_back({{"robot", robot}, {"points", outline}, {"support", rounded(o.support, 0.01)}});
    }
    if (corners_) state["corner"] = corner_drawing(shown);
    if (tag_camera_) state["seen"] = tag_drawing(shown);
    if (locator_) state["seen"] = landmark_drawing(shown);
}

}  // namespace roomfix
