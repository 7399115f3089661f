#include "roomfix/calibrate/lens_start.hpp"

#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "roomfix/geometry/floor_points.hpp"

namespace roomfix {
namespace {

Eigen::Isometry3d pose_of(const cv::Mat& rotation, const cv::Mat& translation) {
    const auto vector = [](const cv::Mat& m) {
        cv::Mat_<double> d;
        m.reshape(1, 3).convertTo(d, CV_64F);
        return Eigen::Vector3d(d(0), d(1), d(2));
    };
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = exponential_rotation(vector(rotation));
    pose.translation() = vector(translation);
    return pose;
}

/// What OpenCV makes of the corners, with the plumb_bob lens.
LensSolution solve_plumb_bob(const std::vector<const BoardShot*>& used, int width, int height, const Chessboard& board) {
    std::vector<std::vector<cv::Point3f>> places;
    std::vector<std::vector<cv::Point2f>> pixels;
    for (const BoardShot* shot : used) {
        places.emplace_back();
        pixels.emplace_back();
        for (std::size_t i = 0; i < shot->corners.size(); ++i) {
            const Eigen::Vector2f at = board.corner(shot->number(i)).cast<float>(), pixel = shot->corners[i].cast<float>();
            places.back().emplace_back(at.x(), at.y(), 0.F);
            pixels.back().emplace_back(pixel.x(), pixel.y());
        }
    }
    cv::Mat matrix, distortion;
    std::vector<cv::Mat> rotations, translations;
    cv::calibrateCamera(places, pixels, {width, height}, matrix, distortion, rotations, translations, 0,
                        {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 200, 1e-12});
    LensSolution solution;
    std::array<double, most_distortion> numbers = {};
    for (int i = 0; i < 5; ++i) numbers[static_cast<std::size_t>(i)] = distortion.at<double>(i);
    solution.model =
        make_camera_model(width, height, matrix.at<double>(0, 0), matrix.at<double>(1, 1), matrix.at<double>(0, 2), matrix.at<double>(1, 2), numbers);
    for (std::size_t i = 0; i < used.size(); ++i) solution.camera_from_board.push_back(pose_of(rotations[i], translations[i]));
    return solution;
}

/// A board's pose from rays through a shot's corners, seen by a camera that is turned towards it; in `rms` how well that fits (rad).
std::optional<Eigen::Isometry3d> pose_from_rays(const std::vector<Eigen::Vector3d>& rays, const BoardShot& shot, const Chessboard& board, double& rms) {
    constexpr double focal = 1000;  // px of a camera that is only imagined
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& ray : rays) middle += ray;
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(middle, Eigen::Vector3d::UnitZ());
    std::vector<FloorPoint> points;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Eigen::Vector3d ray = turn * rays[i];
        if (!(ray.z() > 0)) return std::nullopt;
        const Eigen::Vector2d at = board.corner(shot.number(i));
        // The board is a floor seen from above: its y runs up there.
        points.push_back({focal * ray.head<2>() / ray.z(), {at.x(), -at.y()}});
    }
    const auto pose = camera_pose_from_floor_points(make_camera_model(1, 1, focal, focal, 0, 0), points, 1);
    if (!pose) return std::nullopt;
    rms = pose->rms / focal;
    const Eigen::Isometry3d floor_from_board(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
    return Eigen::Isometry3d(turn.inverse()) * pose->map_from_camera.pose.inverse() * floor_from_board;
}

/// A fisheye without further bending, of the focal length that explains the boards best. OpenCV's own start does not find lenses whose
/// boards were shown strongly tilted.
std::optional<LensSolution> start_equidistant(const std::vector<const BoardShot*>& used, int width, int height, const Chessboard& board) {
    std::optional<LensSolution> best;
    double least = 1e300;
    for (double focal = 0.15 * width; focal < 2 * width; focal *= 1.1) {
        LensSolution tried;
        tried.model = make_camera_model(width, height, focal, focal, 0.5 * (width - 1), 0.5 * (height - 1), {}, Distortion::equidistant);
        double squares = 0;
        for (const BoardShot* shot : used) {
            std::vector<Eigen::Vector3d> rays;
            for (const Eigen::Vector2d& corner : shot->corners) {
                if (const auto ray = unproject(tried.model, corner)) rays.push_back(ray->homogeneous().normalized());
            }
            double rms = 0;
            const auto pose = rays.size() == shot->corners.size() ? pose_from_rays(rays, *shot, board, rms) : std::nullopt;
            if (!pose) break;
            tried.camera_from_board.push_back(*pose);
            squares += focal * rms * focal * rms;
        }
        if (tried.camera_from_board.size() < used.size() || squares >= least) continue;
        least = squares;
        best = std::move(tried);
    }
    return best;
}

}  // namespace

std::optional<LensSolution> start_of_lens(const std::vector<const BoardShot*>& used, int width, int height, const Chessboard& board, Distortion kind) {
    if (kind == Distortion::equidistant) return start_equidistant(used, width, height, board);
    try {
        LensSolution start = solve_plumb_bob(used, width, height, board);
        start.model.kind = kind;  // the rational one without its lower half
        start.model.prepare();
        return start;
    } catch (const cv::Exception&) {
        return std::nullopt;
    }
}

}  // namespace roomfix
