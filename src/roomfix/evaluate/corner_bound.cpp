#include "roomfix/evaluate/corner_bound.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/corner/corner_fit.hpp"

namespace roomfix {
namespace {

constexpr double reach = 15;  // px to both sides of an edge

struct PixelOfEdge {
    double distance, light, noise;  // px, linear light, its standard deviation
};

std::vector<PixelOfEdge> pixels_around(const LineStretch& stretch, const std::vector<float>& light, int width, int height, const SensorModel& sensor) {
    std::vector<PixelOfEdge> pixels;
    const Eigen::Vector2d along = (stretch.to - stretch.from).normalized();
    const Eigen::Vector2d normal = stretch.normal();
    const double length = (stretch.to - stretch.from).norm();
    const Eigen::Vector2d low = stretch.from.cwiseMin(stretch.to).array() - reach;
    const Eigen::Vector2d high = stretch.from.cwiseMax(stretch.to).array() + reach;
    for (int y = std::max(0, static_cast<int>(low.y())); y <= std::min(height - 1, static_cast<int>(high.y()) + 1); ++y) {
        for (int x = std::max(0, static_cast<int>(low.x())); x <= std::min(width - 1, static_cast<int>(high.x()) + 1); ++x) {
            const Eigen::Vector2d off = Eigen::Vector2d(x, y) - stretch.from;
            const double run = along.dot(off);
            const double distance = normal.dot(off);
            if (run < 0 || run >= length || std::abs(distance) > reach) continue;
            const double part = std::clamp(static_cast<double>(light[static_cast<std::size_t>(y * width + x)]) / 255, 1e-4, 1.0);
            const double grey = 255 * std::pow(part, 1 / sensor.gamma);
            const double by_grey = sensor.gamma * std::pow(grey / 255, sensor.gamma - 1);
            const double noise = pixel_noise(sensor, grey);
            pixels.push_back({distance, 255 * part, by_grey * std::sqrt(noise * noise + 1.0 / 12)});
        }
    }
    return pixels;
}

/// Information about a stretch's place across itself, 1/px^2.
double information_of(const std::vector<PixelOfEdge>& pixels, double blur) {
    using Row = Eigen::Matrix<double, 4, 1>;
    Eigen::Matrix4d nuisance = Eigen::Matrix4d::Zero();
    Row right = Row::Zero();
    Row cross = Row::Zero();
    double own = 0;
    for (const PixelOfEdge& pixel : pixels) {
        const double z = pixel.distance / blur;
        const double bell = std::exp(-0.5 * z * z) / (std::sqrt(2 * std::numbers::pi) * blur);
        const double step = 0.5 * std::erfc(-z / std::numbers::sqrt2);
        Row row;
        row << 1, pixel.distance, step, pixel.distance * step + blur * blur * bell;
        const double weight = 1 / (pixel.noise * pixel.noise);
        nuisance += weight * row * row.transpose();
        right += weight * pixel.light * row;
        cross += weight * bell * row;
        own += weight * bell * bell;
    }
    const Eigen::LDLT<Eigen::Matrix4d> solver(nuisance);
    const double contrast = solver.solve(right)[2];
    return contrast * contrast * (own - cross.dot(solver.solve(cross)));
}

}  // namespace

CornerView true_view(const RoomShot& shot) {
    const Eigen::Matrix3d corner_from_map = Eigen::AngleAxisd(-shot.corner.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Vector3d camera = corner_from_map * (shot.map_from_camera.translation() - shot.corner.position);
    return {corner_from_map * shot.map_from_camera.linear(), camera.head<2>() / -camera.z()};
}

Matrix5d corner_information(const RoomShot& shot, const CameraModel& model, const SensorModel& sensor, const GlareModel& glare) {
    SensorModel linear = sensor;
    linear.gamma = 1;
    RoomRenderer renderer(model, linear, glare, 1);
    const std::vector<float>& light = renderer.expose(shot.scene, shot.map_from_camera, shot.light);
    // The stretches of the true edges, and how they move with the five unknowns.
    CornerFit fit;
    fit.view = true_view(shot);
    const CornerFitter fitter(model);
    fitter.look_like({.blur = 1, .reach = 1}, fit);
    const LumaImage nothing(model.width, model.height);
    fitter.read(nothing, std::numbers::pi / 2, 1, fit);
    const double blur = std::sqrt(sensor.blur * sensor.blur + 1.0 / 12);
    Matrix5d information = Matrix5d::Zero();
    for (const EdgePiece& piece : fit.pieces) {
        information += information_of(pixels_around(piece.stretch, light, model.width, model.height, sensor), blur) * piece.slope * piece.slope.transpose();
    }
    return information;
}

}  // namespace roomfix
