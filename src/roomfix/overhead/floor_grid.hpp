// The places on the floor at which a body is looked for.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "roomfix/overhead/place_score.hpp"

namespace roomfix {

struct FloorGridSettings {
    double step = 0.1;    // m; it grows where the floor is larger
    int most = 40000;     // places
    double farthest = 8;  // times the camera's height: nobody locates robots beyond
};

/// The floor that some camera sees, in even steps along the map's axes. Cameras, walls and bodies are the same from frame to frame: where a body would lie in
/// the pictures is computed once.
class FloorGrid {
public:
    /// px of the small picture, right and below exclusive; nothing where the camera says nothing about the place.
    struct Box {
        std::int16_t left = 0, above = 0, right = 0, below = 0;

        bool empty() const { return right <= left || below <= above; }
    };

    /// Is it that of these cameras and a body of this size?
    bool fits(std::span<const SeenBy> cameras, const Body& body, const FloorGridSettings& settings) const;
    void lay(std::span<const SeenBy> cameras, const Body& body, const FloorGridSettings& settings);

    /// Places side by side: begin <= p < end.
    struct Patch {
        Eigen::Vector2d middle;  // m, map
        std::size_t begin = 0, end = 0;
    };
    static constexpr int patch_places = 3;  // along each side

    /// Those with any place.
    std::span<const Patch> patches() const { return patches_; }
    /// m, map: those that lie in some camera's picture, and are not hidden from it by walls.
    std::span<const Eigen::Vector2d> places() const { return places_; }
    /// Around the body that stands at a place, one for each camera.
    std::span<const Box> boxes(std::size_t place) const { return {boxes_.data() + place * pictures_.size(), pictures_.size()}; }

private:
    struct Picture {
        View view;
        int width = 0, height = 0, scale = 1;
        std::vector<Polyline> walls;
    };
    void add_patch(std::span<const SeenBy> cameras, const Body& body, const Eigen::Vector2d& corner, const Eigen::Vector2d& end, double step);
    Box box_at(const SeenBy& camera, const Body& body, const Eigen::Vector2d& place) const;

    FloorGridSettings settings_;
    double radius_ = 0, body_height_ = 0;  // m
    std::vector<Picture> pictures_;
    std::vector<Patch> patches_;
    std::vector<Eigen::Vector2d> places_;
    std::vector<Box> boxes_;
};

}  // namespace roomfix
