#include "roomfix/overhead/li2014.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace roomfix {
namespace {

/// (1)-(5): the pixel that a lens without distortion would have given. The paper warps the whole image; a point is enough.
std::optional<Eigen::Vector2d> corrected(const CameraModel& model, const Eigen::Vector2d& pixel) {
    const auto ray = unproject(model, pixel);
    if (!ray) return std::nullopt;
    return Eigen::Vector2d(model.fx * ray->x() + model.cx, model.fy * ray->y() + model.cy);
}

/// (19), (20): where the line through `a` and `b` crosses image row y.
double line_at_row(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double y) { return a.x() + (b.x() - a.x()) * (y - a.y()) / (b.y() - a.y()); }

}  // namespace

Li2014Aisle li2014_aisle_ahead(const View& view) {
    const Eigen::Vector3d forward = view.map_from_camera.pose.linear().col(2);
    return {view.position().head<2>(), forward.head<2>().normalized()};
}

std::optional<Li2014Rectangle> li2014_rectangle_ahead(const View& view) {
    const Li2014Aisle aisle = li2014_aisle_ahead(view);
    const auto distance_at = [&](double row) -> std::optional<double> {
        const auto floor = pixel_to_plane(view, {view.model.cx, row * (view.model.height - 1)}, 0);
        if (!floor) return std::nullopt;
        return aisle.direction.dot(floor->point - aisle.camera);
    };
    const auto near = distance_at(0.95);
    const auto far = distance_at(0.6);
    if (!near || !far || !(*far > *near)) return std::nullopt;
    constexpr double half_width = 0.45;  // m
    const Eigen::Vector2d left(-aisle.direction.y(), aisle.direction.x());
    const auto pixel = [&](double along, double across) {
        const Eigen::Vector2d p = aisle.camera + along * aisle.direction + across * left;
        return project_map_point(view, {p.x(), p.y(), 0});
    };
    const auto left_near = pixel(*near, half_width);
    const auto left_far = pixel(*far, half_width);
    const auto right_near = pixel(*near, -half_width);
    const auto right_far = pixel(*far, -half_width);
    if (!left_near || !left_far || !right_near || !right_far) return std::nullopt;
    return Li2014Rectangle{*left_near, *left_far, *right_near, *right_far, 2 * half_width, *far - *near, *near, half_width};
}

Result<Li2014> Li2014::set_up(const CameraModel& model, const Li2014Rectangle& rectangle, const Li2014Aisle& aisle, const Li2014Settings& settings) {
    Li2014 webcam;
    webcam.model_ = model;
    webcam.aisle_ = aisle;
    webcam.settings_ = settings;
    webcam.d_n_ = rectangle.width;
    webcam.left_offset_ = rectangle.left_offset;
    const std::array<Eigen::Vector2d, 4> clicked = {rectangle.left_near, rectangle.left_far, rectangle.right_near, rectangle.right_far};
    for (std::size_t i = 0; i < 4; ++i) {
        const auto point = corrected(model, clicked[i]);
        if (!point) return Error{"a corner of the rectangle is outside what the lens model can see"};
        webcam.ls_[i] = *point;
    }
    if (!(rectangle.width > 0) || !(rectangle.length > 0)) return Error{"the rectangle's width and length must be above 0"};
    if (std::abs(webcam.ls_[0].y() - webcam.ls_[1].y()) < 1 || std::abs(webcam.ls_[2].y() - webcam.ls_[3].y()) < 1) {
        return Error{"the rectangle's sides run along the image rows: choose one whose sides lead away from the camera"};
    }

    // (18), corrected: the printed form has theta_H where half the angle of view is meant. N(y) is linear in the row y, so
    // d = K / N - h_s exactly; two rows, the rectangle's edges, give both constants.
    const auto width_at = [&](double y) { return line_at_row(webcam.ls_[2], webcam.ls_[3], y) - line_at_row(webcam.ls_[0], webcam.ls_[1], y); };
    const double n_near = width_at(0.5 * (webcam.ls_[0].y() + webcam.ls_[2].y()));
    const double n_far = width_at(0.5 * (webcam.ls_[1].y() + webcam.ls_[3].y()));
    if (!(n_far > 0) || !(n_near > n_far)) return Error{"the rectangle's far edge must look shorter than its near edge"};
    webcam.k_ = rectangle.length / (1 / n_far - 1 / n_near);
    webcam.h_s_ = webcam.k_ / n_near - rectangle.near_distance;
    return webcam;
}

void Li2014::set_background(const std::vector<LumaImage>& frames) {
    if (frames.empty()) return;
    const int width = frames[0].width();
    const int height = frames[0].height();
    std::vector<float> mean(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0f);
    for (const LumaImage& frame : frames) {
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) mean[static_cast<std::size_t>(y * width + x)] += frame.row(y)[x];
        }
    }
    background_.resize(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            float sum = 0;  // low-pass: mean of 3 x 3
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    const int u = std::clamp(x + dx, 0, width - 1);
                    const int v = std::clamp(y + dy, 0, height - 1);
                    sum += mean[static_cast<std::size_t>(v * width + u)];
                }
            }
            background_.row(y)[x] = static_cast<std::uint8_t>(std::lround(sum / (9.0f * static_cast<float>(frames.size()))));
        }
    }
}

std::optional<Eigen::Vector2d> Li2014::locate(LumaView frame) {
    if (background_.empty() || frame.width != background_.width() || frame.height != background_.height()) return std::nullopt;
    const auto r_center = find_r_center(frame);
    update_background(frame);
    if (!r_center) return std::nullopt;
    return floor_point(*r_center);
}

/// Figure 2: difference (14), binarisation (13), opening and closing, labelling, R_center = mean of the blob's pixels.
std::optional<Eigen::Vector2d> Li2014::find_r_center(LumaView frame) {
    if (foreground_.width() != frame.width || foreground_.height() != frame.height) foreground_.resize(frame.width, frame.height);
    foreground_.clear();
    for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
            if (std::abs(frame.at(x, y) - background_.row(y)[x]) >= settings_.threshold) foreground_.set(x, y);
        }
    }
    open(foreground_, scratch_);
    close(foreground_, scratch_);
    const auto& blobs = labels_.find(foreground_, 100);
    if (blobs.empty()) return std::nullopt;
    return blobs[0].centroid;
}

/// (23). In print both cases assign f_current and the sentence above has the inequality reversed; meant is: take the frame
/// as the new background when nothing moves, s(f_fg) < t_1, and keep the old one otherwise.
void Li2014::update_background(LumaView frame) {
    if (++frames_since_refresh_ < settings_.refresh_frames) return;
    frames_since_refresh_ = 0;
    int fullest = 0;
    for (int y = 0; y < frame.height; ++y) fullest = std::max(fullest, foreground_.count_run(y, 0, frame.width));
    if (fullest < settings_.projection) background_ = copy_of(frame);
}

std::optional<Eigen::Vector2d> Li2014::floor_point(const Eigen::Vector2d& r_center) const {
    const auto r = corrected(model_, r_center);
    if (!r) return std::nullopt;
    const double p = line_at_row(ls_[0], ls_[1], r->y());
    const double q = line_at_row(ls_[2], ls_[3], r->y());
    const double n_pq = q - p;                       // (21)
    if (!(n_pq > 0)) return std::nullopt;            // above the horizon
    const double d = ibdms(n_pq);                    // (18)
    const double w_pr = d_n_ * (r->x() - p) / n_pq;  // (22)
    const Eigen::Vector2d left(-aisle_.direction.y(), aisle_.direction.x());
    return aisle_.camera + d * aisle_.direction + (left_offset_ - w_pr) * left;  // (15)-(17)
}

}  // namespace roomfix
