#include "roomfix/overhead/outline_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "roomfix/base/beta_distribution.hpp"
#include "roomfix/base/decompositions.hpp"
#include "roomfix/overhead/edge_profile.hpp"
#include "roomfix/overhead/wall_cover.hpp"

namespace roomfix {
namespace {

using Vector4d = Eigen::Vector4d;
using Matrix4d = Eigen::Matrix4d;
constexpr int most_samples = 192;
constexpr int widest_shadow = 28;    // px
constexpr double beside_others = 3;  // px
// A body larger by some length has each of its sides farther out by half of that. Most of it is common to all sides, since
// opposite ones move alike: 60 % of the variance; the rest is each side's own.
constexpr double common_size = 0.5 * 0.775;
constexpr double own_size = 0.5 * 0.632;

/// A place on the predicted outline where the picture is asked for an edge.
struct Sample {
    Eigen::Vector2d pixel;
    Eigen::Vector2d normal;  // outwards, unit
    Vector4d by_state;       // d(outline position along the normal) / d(x, y, yaw, inset)
    Eigen::Matrix<double, 1, 6> by_calibration;
    int edge = 0;  // number of the outline's side
    bool on_floor = false;
    double scale = 0;  // px per metre along the normal, for the size error
    EdgeReading reading;
};

struct Samples {
    std::array<Sample, most_samples> list;
    int count = 0;
    int total = 0;
    double spacing = 2;  // px along the outline from sample to sample
    std::span<Sample> all() { return {list.data(), static_cast<std::size_t>(count)}; }
    std::span<const Sample> all() const { return {list.data(), static_cast<std::size_t>(count)}; }
};

/// The walls that may hide something of a body.
class WallsBefore {
public:
    WallsBefore(const FrameEvidence& evidence, const View& view, const Eigen::Vector2d& place, double radius) : view_(view) {
        if (evidence.walls && !in_plain_view(view, *evidence.walls, place, 1.2 * radius)) walls_ = evidence.walls;
    }
    bool hide(const Eigen::Vector3d& point) const {
        constexpr double beside = 4;  // px: there a wall's own edge is seen
        return walls_ && behind_wall(view_, *walls_, point.head<2>(), beside / view_.model.fx);
    }

private:
    const View& view_;
    const std::vector<Polyline>* walls_ = nullptr;
};

/// The outlines of a body's parts at a pose.
struct PartOutlines {
    std::array<Silhouette, most_parts> list;
    std::size_t count = 0;

    /// False: some part is behind the camera or outside the lens model.
    bool project(const View& view, std::span<const ShapePoints> parts, const Pose2& pose) {
        count = std::min(parts.size(), list.size());
        for (std::size_t i = 0; i < count; ++i) {
            list[i] = project_silhouette(view, parts[i], pose);
            if (!list[i].valid()) return false;
        }
        return count > 0;
    }

    /// Does the whole body end where a part does? Not where another part covers that place, or lies right beside it.
    bool ends_with(std::size_t part, const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal) const {
        constexpr double touching = 1;  // px: sides of parts that stand on each other lie on one line
        constexpr double beside = 3;    // px
        for (std::size_t i = 0; i < count; ++i) {
            if (i == part) continue;
            if (inside_polygon(list[i].polygon(), pixel, -touching) || inside_polygon(list[i].polygon(), pixel + beside * normal, -touching)) return false;
        }
        return true;
    }
};

/// From corner to corner of a silhouette, with its normal outwards; both px.
struct Side {
    Eigen::Vector2d from, to, normal;
};
Side side_of(const Silhouette& silhouette, int number) {
    const Eigen::Vector2d& from = silhouette.corners[static_cast<std::size_t>(number)];
    const Eigen::Vector2d& to = silhouette.corners[static_cast<std::size_t>((number + 1) % silhouette.count)];
    const Eigen::Vector2d along = (to - from).normalized();
    return {from, to, {along.y(), -along.x()}};
}

/// Length of the whole body's outline, px.
double length_of(const PartOutlines& outlines) {
    constexpr int probes = 4;
    double length = 0;
    for (std::size_t part = 0; part < outlines.count; ++part) {
        for (int i = 0; i < outlines.list[part].count; ++i) {
            const Side side = side_of(outlines.list[part], i);
            int outside = 0;
            for (int k = 0; k < probes; ++k) outside += outlines.ends_with(part, side.from + (side.to - side.from) * ((k + 0.5) / probes), side.normal);
            length += (side.to - side.from).norm() * outside / probes;
        }
    }
    return length;
}

/// Spreads samples along the outline at `pose`. Keeps those inside the image and not behind others or walls. False: the body is not all before the camera.
bool place_samples(const FrameEvidence& evidence, const View& view, std::span<const ShapePoints> parts, const Pose2& pose, std::span<const Silhouette> others,
                   int most, Samples& samples) {
    samples.count = 0;
    samples.total = 0;
    PartOutlines outlines;
    if (!outlines.project(view, parts, pose)) return false;
    const WallsBefore walls(evidence, view, {pose.x, pose.y}, parts.front().radius);
    const double spacing = std::max(2.0, length_of(outlines) / std::min(most, most_samples - ShapePoints::capacity));
    const double width = evidence.frame.width - 1.0;
    const double height = evidence.frame.height - 1.0;
    samples.spacing = spacing;
    double carried = 0;  // sides shorter than the spacing share their samples
    for (std::size_t part = 0; part < outlines.count; ++part) {
        const Silhouette& silhouette = outlines.list[part];
        const Eigen::Vector2d middle = polygon_centroid(silhouette.polygon());
        for (int i = 0; i < silhouette.count; ++i) {
            const auto here = static_cast<std::size_t>(i);
            const auto next = static_cast<std::size_t>((i + 1) % silhouette.count);
            const double side = (silhouette.corners[next] - silhouette.corners[here]).norm();
            const int count = static_cast<int>((side + carried) / spacing);
            carried = side + carried - count * spacing;
            if (count == 0) continue;
            const Eigen::Vector3d from = body_point_map(parts[part], silhouette.indices[here], pose);
            const Eigen::Vector3d to = body_point_map(parts[part], silhouette.indices[next], pose);
            // Image points of even spacing are not even in space; good enough within one side.
            for (int k = 0; k < count && samples.count < most_samples; ++k) {
                const Eigen::Vector3d p = from + (to - from) * ((k + 0.5) / count);
                ViewJacobian jacobian;
                const auto pixel = project_map_point(view, p, &jacobian);
                if (!pixel) {
                    ++samples.total;
                    continue;
                }
                const Eigen::Vector2d tangent = (jacobian.by_point * (to - from)).normalized();
                Eigen::Vector2d normal(tangent.y(), -tangent.x());
                if (normal.dot(*pixel - middle) < 0) normal = -normal;
                if (!outlines.ends_with(part, *pixel, normal)) continue;
                ++samples.total;
                if (pixel->x() < 3 || pixel->y() < 3 || pixel->x() > width - 3 || pixel->y() > height - 3) continue;
                if (inside_any(others, *pixel, beside_others) || walls.hide(p)) continue;
                Sample& s = samples.list[static_cast<std::size_t>(samples.count++)];
                s.pixel = *pixel;
                s.normal = normal;
                const Eigen::RowVector3d along = s.normal.transpose() * jacobian.by_point;
                s.by_state << along.x(), along.y(), along.y() * (p.x() - pose.x) - along.x() * (p.y() - pose.y), 1;
                s.by_calibration = jacobian.by_calibration(view, Eigen::RowVector2d(s.normal.transpose()));
                s.scale = along.norm();
                s.edge = static_cast<int>(part) * ShapePoints::capacity + i;
                s.on_floor = p.z() < 1e-6;
                s.reading = {};
            }
        }
    }
    return true;
}

/// Standard deviation of one reading, without what its edge has in common.
double reading_sigma(const Sample& s, const OutlineFitSettings& settings) {
    return std::sqrt(s.reading.sigma * s.reading.sigma + settings.edge_noise * settings.edge_noise);
}

/// Variance of the error that all readings of an edge share.
double common_variance(const Sample& s, const ShapePoints& shape, const OutlineFitSettings& settings) {
    const double size = own_size * shape.size_sigma * s.scale;
    const double floor = s.on_floor ? settings.floor_noise : 0;
    const double shadow = s.reading.shadowed ? 2 * settings.common_noise : 0;
    // A level that is off by some part of the light moves an edge the farther, the weaker it is; it is two pixels wide.
    const double weak = s.reading.contrast > 0 ? 2 * settings.disturbance / s.reading.contrast : 0;
    return settings.common_noise * settings.common_noise + size * size + floor * floor + shadow * shadow + weak * weak;
}

struct Normal {
    Matrix4d information;
    Vector4d gradient;
    Eigen::Matrix<double, 4, 6> by_calibration;  // J^T W d(reading)/d(camera)
    double squares = 0;
    double edge_squares = 0;  // squared mean residual of each edge over its variance, summed
    int edges = 0;
    int used = 0;
};

/// Weighted least squares of the readings, robust by Geman and McClure's weight: a reading off by much more than
/// `robust_scale` (px) has no say, such as one on a recess of the body. Readings of one edge share an error:
/// W = (D + c 1 1^T)^-1, applied edge by edge with the Sherman-Morrison formula.
Normal accumulate(const Samples& samples, const ShapePoints& shape, const OutlineFitSettings& settings, const Vector4d& state, double robust_scale) {
    Normal normal{Matrix4d::Zero(), Vector4d::Zero(), Eigen::Matrix<double, 4, 6>::Zero()};
    double scale = 0;
    for (const Sample& s : samples.all()) scale += s.scale / samples.count;
    const double inset = std::hypot(settings.inset_noise, common_size * shape.size_sigma * scale);
    normal.information(3, 3) = 1 / (inset * inset);
    normal.gradient[3] = -state[3] * normal.information(3, 3);
    const auto all = samples.all();
    for (std::size_t first = 0; first < all.size();) {
        std::size_t last = first;
        double sum = 0;
        double common = 0;
        Vector4d by_state = Vector4d::Zero();
        Eigen::Matrix<double, 1, 6> by_calibration = Eigen::Matrix<double, 1, 6>::Zero();
        double residuals = 0;
        for (; last < all.size() && all[last].edge == all[first].edge; ++last) {
            const Sample& s = all[last];
            if (!s.reading.found) continue;
            const double sigma = reading_sigma(s, settings);
            const double residual = s.reading.offset - s.by_state.dot(state);
            const double relative2 = residual * residual / (robust_scale * robust_scale + common_variance(s, shape, settings));
            const double weight = 1 / (sigma * sigma * (1 + relative2) * (1 + relative2));
            normal.information += weight * s.by_state * s.by_state.transpose();
            normal.gradient += weight * residual * s.by_state;
            normal.by_calibration += weight * s.by_state * s.by_calibration;
            normal.squares += weight * residual * residual;
            sum += weight;
            common = std::max(common, common_variance(s, shape, settings));
            by_state += weight * s.by_state;
            by_calibration += weight * s.by_calibration;
            residuals += weight * residual;
            ++normal.used;
        }
        if (sum > 0) {
            const double factor = common / (1 + common * sum);
            normal.information -= factor * by_state * by_state.transpose();
            normal.gradient -= factor * residuals * by_state;
            normal.by_calibration -= factor * by_state * by_calibration;
            normal.squares -= factor * residuals * residuals;
            const double mean = residuals / sum;
            normal.edge_squares += mean * mean / (1 / sum + common);
            ++normal.edges;
        }
        first = last;
    }
    return normal;
}

void read_edges(const FrameEvidence& evidence, int reach, Samples& samples) {
    for (Sample& s : samples.all()) s.reading = read_edge(evidence, s.pixel, s.normal, reach);
}

/// One step of the pose from fixed readings: a few robust iterations on the linearised outline.
Vector4d solve_state(const Samples& samples, const ShapePoints& shape, const OutlineFitSettings& settings, double robust_scale, bool& solved) {
    Vector4d state = Vector4d::Zero();
    solved = false;
    for (int i = 0; i < 3; ++i) {
        Normal normal = accumulate(samples, shape, settings, state, robust_scale);
        if (shape.round()) normal.information(2, 2) += 1;  // yaw does not show; keep it where it is
        normal.information.diagonal().head<2>().array() += 1e-3;
        normal.information(2, 2) += 1e-3;
        const Eigen::LDLT<Matrix4d> solver(normal.information);
        if (normal.used < 6 || solver.info() != Eigen::Success) return state;
        const Vector4d step = solver.solve(normal.gradient);
        state += step;
        solved = true;
        if (step.head<2>().norm() < 1e-5) break;
    }
    return state;
}

/// Parts of an outline that show an edge: Beta distribution.
struct Shown {
    double edges, bare;
};

/// Nats for one of two explanations of an outline.
struct OutlineEvidence {
    double share = 0;    // from how much of it shows an edge
    double scatter = 0;  // from how far these are off

    double all() const { return share + scatter; }
};

/// With the other explanation edges scatter `wider` than stated.
OutlineEvidence evidence_for(const Shown& one, const Shown& other, double wider, const OutlineFit& fit, double independent) {
    const double shown = independent * fit.supported;
    const double visible = independent * fit.visible;
    const double variance = wider * wider;
    return {log_beta_evidence(shown, visible, one.edges, one.bare) - log_beta_evidence(shown, visible, other.edges, other.bare),
            shown * 0.5 * (std::log(variance) - fit.residual * fit.residual * (1 - 1 / variance))};
}

/// How much of its left or right side (`sign` of the normal) shows an edge where the outline has it.
double shown_on_side(const Samples& samples, double sign) {
    constexpr double near = 1;  // px
    int all = 0, shown = 0;
    for (const Sample& s : samples.all()) {
        if (sign * s.normal.x() <= std::abs(s.normal.y())) continue;
        ++all;
        shown += s.reading.found && !s.reading.on_background_edge && std::abs(s.reading.offset) < near;
    }
    return all > 0 ? static_cast<double>(shown) / all : 1;
}

/// Counts what the readings say at the final pose.
void judge(const Samples& samples, const ShapePoints& shape, const OutlineFitSettings& settings, OutlineFit& fit) {
    fit.total = samples.total;
    fit.visible = samples.count;
    fit.supported = fit.covered = fit.bare = fit.ambiguous = fit.into_shadow = 0;
    double support = 0;
    for (const Sample& s : samples.all()) {
        const double usual = std::hypot(1.0, shape.size_sigma * s.scale);  // px: an edge so far off the outline counts half
        if (s.reading.found && std::abs(s.reading.offset) < 2 * usual) {
            if (s.reading.on_background_edge) {
                ++fit.ambiguous;
                continue;
            }
            ++fit.supported;
            fit.into_shadow += s.on_floor && s.reading.into_shadow;
            support += 1 / (1 + s.reading.offset * s.reading.offset / (usual * usual));
        } else if (s.reading.inside_foreground && s.reading.outside_foreground) {
            ++fit.covered;
        } else if (!s.reading.inside_foreground && !s.reading.outside_foreground) {
            ++fit.bare;
        }
    }
    const double independent = std::min(1.0, samples.spacing / settings.edge_length);
    fit.edges = independent * (fit.supported * std::log(settings.edge_shown / settings.edge_chance) +
                               (fit.visible - fit.supported) * std::log((1 - settings.edge_shown) / (1 - settings.edge_chance)));
    const int conflicting = fit.visible - fit.supported - fit.covered - fit.bare - fit.ambiguous;
    fit.score = fit.visible > 0 ? (support - 0.7 * fit.covered - 0.15 * fit.bare - 0.4 * conflicting) / fit.visible : -1;
}

void set_covariance(const Samples& samples, const ShapePoints& shape, const OutlineFitSettings& settings, double inset, OutlineFit& fit) {
    Normal normal = accumulate(samples, shape, settings, Vector4d(0, 0, 0, inset), settings.last_scale);
    if (shape.round()) normal.information(2, 2) += 1 / (M_PI * M_PI / 3);  // uniform over a turn
    const Eigen::LDLT<Matrix4d> solver(normal.information);
    const int freedom = normal.used - 4;
    if (freedom < 4 || solver.info() != Eigen::Success || !(solver.vectorD().array() > 1e-9).all()) return;
    const Matrix4d inverse = solver.solve(Matrix4d::Identity());
    fit.residual = std::sqrt(std::max(normal.squares, 0.0) / freedom);
    // Readings that scatter more than their noise says make the fix as uncertain as they are.
    const double by_readings = fit.residual * fit.residual;
    // So do edges that contradict each other, beyond what happens by chance once in a hundred times.
    const int edge_freedom = std::max(normal.edges - 3, 1);
    const double by_edges = normal.edge_squares / edge_freedom;
    const double inflation = std::max({1.0, by_readings, by_edges > 1 + 3.5 / edge_freedom ? by_edges : 1.0});
    fit.pixel_covariance = inverse.topLeftCorner<3, 3>() * inflation;
    fit.by_calibration = (inverse * normal.by_calibration).topRows<3>();
    fit.covariance = fit.pixel_covariance + fit.by_calibration * fit.by_calibration.transpose();
    fit.covariance = (0.5 * (fit.covariance + fit.covariance.transpose())).eval();
    const double independent = std::min(1.0, samples.spacing / settings.edge_length);
    fit.exact =
        evidence_for({settings.exact_shown, settings.exact_bare}, {settings.rough_shown, settings.rough_bare}, settings.rough_scatter, fit, independent).all();
    const OutlineEvidence right =
        evidence_for({settings.right_shown, settings.right_bare}, {settings.wrong_shown, settings.wrong_bare}, settings.wrong_scatter, fit, independent);
    fit.right = right.all();
    fit.present = right.share + settings.side_scatter * right.scatter;
    fit.determined = true;
}

}  // namespace

double squared_distance(const OutlineFit& fit, const Pose2& pose, const Eigen::Matrix3d& covariance) {
    const Eigen::Vector2d off(fit.pose.x - pose.x, fit.pose.y - pose.y);
    const Eigen::Matrix2d spread = (covariance + fit.covariance).topLeftCorner<2, 2>();
    return off.dot(spread.inverse() * off);
}

OutlineFit fit_outline(const FrameEvidence& evidence, const View& view, std::span<const ShapePoints> parts, const Pose2& start,
                       std::span<const Silhouette> others, const OutlineFitSettings& settings) {
    OutlineFit fit;
    fit.pose = start;
    const ShapePoints& shape = parts.front();
    Samples samples;
    double inset = 0;
    for (int round = 0; round <= settings.rounds; ++round) {
        const double progress = std::min(1.0, static_cast<double>(round) / std::max(1, settings.coarse_rounds));
        const int most = progress < 1 ? settings.samples / 2 : settings.samples;  // half are enough to come near
        if (!place_samples(evidence, view, parts, fit.pose, others, most, samples)) return fit;
        const int reach = settings.first_reach + static_cast<int>(std::lround(progress * (settings.last_reach - settings.first_reach)));
        read_edges(evidence, reach, samples);
        if (round == settings.rounds) break;
        bool solved = false;
        const Vector4d step = solve_state(samples, shape, settings, settings.first_scale + progress * (settings.last_scale - settings.first_scale), solved);
        if (!solved || step.head<2>().norm() > 2 * shape.radius) break;
        inset = step[3];
        fit.pose.x += step[0];
        fit.pose.y += step[1];
        fit.pose.yaw += std::clamp(step[2], -0.5, 0.5);
        if (progress >= 1 && step.head<2>().norm() < 5e-4 && std::abs(step[2]) < 1e-3) break;
    }
    judge(samples, shape, settings, fit);
    fit.left_shown = shown_on_side(samples, -1);
    fit.right_shown = shown_on_side(samples, 1);
    set_covariance(samples, shape, settings, inset, fit);
    fit.silhouette = project_silhouette(view, shape, fit.pose);
    fit.pose.yaw = wrap_angle(fit.pose.yaw);
    return fit;
}

OutlineFit fit_outline(const FrameEvidence& evidence, const View& view, const ShapePoints& shape, const Pose2& start, std::span<const Silhouette> others,
                       const OutlineFitSettings& settings) {
    return fit_outline(evidence, view, std::span(&shape, 1), start, others, settings);
}

std::optional<Pose2> pose_behind_shadow(const FrameEvidence& evidence, const View& view, std::span<const ShapePoints> parts, const OutlineFit& fit,
                                        const OutlineFitSettings& settings) {
    Samples samples;
    if (!place_samples(evidence, view, parts, fit.pose, {}, settings.samples, samples)) return std::nullopt;
    // Least squares over how far in the next edge is.
    Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    int lower = 0;
    int found = 0;
    for (const Sample& s : samples.all()) {
        if (!s.on_floor) continue;
        ++lower;
        const Eigen::Vector2d inside = s.pixel - widest_shadow / 2.0 * s.normal;
        if (inside.x() < 3 || inside.y() < 3 || inside.x() > evidence.frame.width - 4 || inside.y() > evidence.frame.height - 4) continue;
        const EdgeReading next = read_edge(evidence, inside, s.normal, widest_shadow / 2 - 2);
        if (!next.found || !next.shadowed) continue;
        ++found;
        const Eigen::Vector2d by_place = s.by_state.head<2>();
        square += by_place * by_place.transpose();
        right += (next.offset - widest_shadow / 2.0) * by_place;
    }
    if (found < 4 || 2 * found < lower) return std::nullopt;
    square.diagonal().array() += 1e-3 * square.trace();  // along an edge nothing is known
    const Eigen::Vector2d move = square.inverse() * right;
    return Pose2{fit.pose.x + move.x(), fit.pose.y + move.y(), fit.pose.yaw};
}

OutlineFit fit_area(const FrameEvidence& evidence, const View& view, const ShapePoints& shape, const Pose2& pose, const OutlineFitSettings& settings) {
    OutlineFit fit;
    fit.pose = pose;
    fit.silhouette = project_silhouette(view, shape, pose);
    if (!fit.silhouette.valid()) return fit;
    Samples samples;
    place_samples(evidence, view, std::span(&shape, 1), pose, {}, settings.samples, samples);
    read_edges(evidence, settings.last_reach, samples);
    judge(samples, shape, settings, fit);
    OutlineFitSettings coarse = settings;
    coarse.common_noise = std::max(1.0, 0.12 * std::sqrt(polygon_area(fit.silhouette.polygon())));
    coarse.edge_noise = coarse.common_noise;
    coarse.inset_noise = coarse.common_noise;
    for (Sample& s : samples.all()) s.reading = {.found = true, .offset = 0, .sigma = coarse.common_noise};
    set_covariance(samples, shape, coarse, 0, fit);
    return fit;
}

}  // namespace roomfix
