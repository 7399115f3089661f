#include "roomfix/evaluate/chou1986_experiment.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/corner/chou1986.hpp"
#include "roomfix/corner/corner_observer.hpp"
#include "roomfix/evaluate/consistency.hpp"
#include "roomfix/evaluate/corner_bound.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {
namespace {

constexpr double right_angle = std::numbers::pi / 2;

Vector5d error_of(const CornerView& truth, const CornerView& found) {
    Vector5d error;
    error.head<3>() = rotation_vector(truth.corner_from_camera * found.corner_from_camera.transpose());
    error.tail<2>() = truth.place - found.place;
    return error;
}

/// Position error over the distance to the corner.
double relative(const Chou1986Trial& t, const Eigen::Vector2d& place_error) { return place_error.norm() * t.ceiling_distance / t.distance; }

double mean_of(const std::vector<Chou1986Trial>& trials, const std::function<std::optional<double>(const Chou1986Trial&)>& value) {
    double sum = 0;
    int count = 0;
    for (const Chou1986Trial& t : trials) {
        if (const auto v = value(t)) {
            sum += *v;
            ++count;
        }
    }
    return count ? sum / count : 0;
}

double largest_of(const std::vector<Chou1986Trial>& trials, const std::function<std::optional<double>(const Chou1986Trial&)>& value) {
    double largest = 0;
    for (const Chou1986Trial& t : trials) largest = std::max(largest, value(t).value_or(0));
    return largest;
}

std::optional<double> our_error(const Chou1986Trial& t) { return t.ours ? std::optional(relative(t, t.error.tail<2>())) : std::nullopt; }
std::optional<double> published_error(const Chou1986Trial& t) {
    return t.published ? std::optional(relative(t, t.truth.place - t.published->place)) : std::nullopt;
}

/// Mean, standard deviation and error percentage of one coordinate over a place's pictures.
struct Coordinate {
    double mean = 0, sigma = 0, percent = 0;
    int count = 0;
};
Coordinate coordinate_of(const std::vector<double>& values, double truth) {
    Coordinate c;
    c.count = static_cast<int>(values.size());
    for (const double v : values) c.mean += v / c.count;
    for (const double v : values) c.sigma += (v - c.mean) * (v - c.mean) / std::max(c.count - 1, 1);
    c.sigma = std::sqrt(c.sigma);
    c.percent = 100 * std::abs(c.mean - truth) / std::abs(truth);
    return c;
}

}  // namespace

namespace {

IntrinsicsMatrix square_root(const IntrinsicsMatrix& covariance) {
    const auto spectrum = symmetric_eigen(covariance);
    return spectrum.eigenvectors() * spectrum.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

/// What its user knows of the camera.
struct KnownLens {
    CameraModel model;
    IntrinsicsMatrix covariance = IntrinsicsMatrix::Zero();
};
Result<KnownLens> known_lens(const CameraModel& truth, const SensorModel& sensor, std::uint64_t seed, const BoardPictures& board) {
    if (board.shots == 0) return KnownLens{truth};
    const auto lens = photographed_lens(truth, sensor, seed, board);
    if (!lens) return lens.error();
    return KnownLens{lens->model, lens->covariance};
}

}  // namespace

Result<Chou1986Report> run_chou1986(const Chou1986Options& options, const std::function<void(double)>& progress) {
    Chou1986Report report;
    report.options = options;
    const CameraModel model = room_camera();
    const SensorModel sensor = room_sensor();
    const GlareModel glare;
    const auto& places = chou1986_places();
    const double total = static_cast<double>(places.size()) * options.seeds * chou1986_pictures;
    CornerResult seen;
    for (int s = 0; s < options.seeds; ++s) {
        const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(s);
        Random random(seed * 7919 + 3);
        RoomRenderer renderer(model, sensor, glare, seed);
        const auto lens = known_lens(model, sensor, seed, options.board);
        if (!lens) return lens.error();
        const IntrinsicsMatrix unit_errors = square_root(lens->covariance);
        CornerObserver observer(lens->model, {right_angle});
        const Chou1986 published(lens->model);
        LumaImage frame;
        for (std::size_t p = 0; p < places.size(); ++p) {
            for (int i = 0; i < chou1986_pictures; ++i) {
                const RoomShot shot = chou1986_shot(places[p], random);
                renderer.render(shot.scene, shot.map_from_camera, shot.light, static_cast<std::uint64_t>(report.trials.size()), frame);
                Chou1986Trial trial;
                trial.place = static_cast<int>(p);
                trial.truth = true_view(shot);
                trial.ceiling_distance = shot.corner.position.z() - shot.map_from_camera.translation().z();
                trial.distance = (shot.map_from_camera.translation() - shot.corner.position).norm();
                observer.observe(frame, {}, seen);
                trial.reason = seen.reason;
                if (!seen.corners.empty()) {
                    trial.ours = seen.corners[0];
                    trial.error = error_of(trial.truth, trial.ours->view);
                    trial.covariance = trial.ours->covariance_with(lens->covariance);
                    trial.by_lens = trial.ours->by_intrinsics * unit_errors;
                    trial.lens = s;
                    trial.bound = trial.covariance - trial.ours->covariance;
                }
                if (options.published) trial.published = published.locate(frame);
                trial.bound += corner_information(shot, model, sensor, glare).inverse();
                report.trials.push_back(trial);
                if (progress) progress(static_cast<double>(report.trials.size()) / total);
            }
        }
    }
    return report;
}

int Chou1986Report::lost() const { return count_lost(trials); }
int Chou1986Report::published_lost() const {
    return static_cast<int>(std::count_if(trials.begin(), trials.end(), [](const Chou1986Trial& t) { return !t.published; }));
}
double Chou1986Report::mean_error() const { return mean_of(trials, our_error); }
double Chou1986Report::largest_error() const { return largest_of(trials, our_error); }
double Chou1986Report::rms_error() const {
    return std::sqrt(mean_of(trials, [](const Chou1986Trial& t) {
        const auto e = our_error(t);
        return e ? std::optional(*e * *e) : std::nullopt;
    }));
}
double Chou1986Report::published_mean_error() const { return mean_of(trials, published_error); }
double Chou1986Report::published_largest_error() const { return largest_of(trials, published_error); }
double Chou1986Report::bound_rms() const {
    return std::sqrt(mean_of(trials, [](const Chou1986Trial& t) {
        const double scale = t.ceiling_distance / t.distance;
        return std::optional((t.bound(3, 3) + t.bound(4, 4)) * scale * scale);
    }));
}
double Chou1986Report::mean_rotation() const {
    return mean_of(trials, [](const Chou1986Trial& t) { return t.ours ? std::optional(t.error.head<3>().norm()) : std::nullopt; });
}
double Chou1986Report::rotation_rms() const {
    return std::sqrt(mean_of(trials, [](const Chou1986Trial& t) { return t.ours ? std::optional(t.error.head<3>().squaredNorm()) : std::nullopt; }));
}
double Chou1986Report::rotation_bound() const {
    return std::sqrt(mean_of(trials, [](const Chou1986Trial& t) { return std::optional(t.bound.topLeftCorner<3, 3>().trace()); }));
}
double Chou1986Report::mean_nees() const {
    return mean_of(trials, [](const Chou1986Trial& t) { return t.ours ? std::optional(t.error.dot(t.covariance.ldlt().solve(t.error))) : std::nullopt; });
}
NeesBand Chou1986Report::nees_band() const {
    std::vector<StatedError> errors;
    for (const Chou1986Trial& t : trials) {
        if (t.ours) errors.push_back({t.ours->covariance, t.by_lens, t.lens});
    }
    return mean_nees_band(errors);
}

std::string chou1986_table(const Chou1986Report& report) {
    std::string text = fmt::format(
        "Chou and Tsai 1986, Fig. 17: 16 places, {} pictures each, Z_c = {:.1f} m. Per place the mean (m), the standard deviation (mm) and the\n"
        "error percentage of the mean, of X_c and Y_c. Printed: the average error percentages are all less than 5 %.\n"
        "      true        |                as published                   |                   roomfix                     |  bound\n"
        "   X_c    Y_c     |  mean X  sigma   e %     mean Y  sigma   e %  |  mean X  sigma   e %     mean Y  sigma   e %  |   mm\n",
        report.options.seeds * chou1986_pictures, chou1986_ceiling - chou1986_camera_height);
    const auto columns = [](const Coordinate& x, const Coordinate& y, bool tried = true) {
        if (x.count == 0) return fmt::format(" {:46}", tried ? "none found" : "not tried");
        return fmt::format(" {:7.4f} {:6.2f} {:6.3f}    {:7.4f} {:6.2f} {:6.3f}  ", x.mean, 1e3 * x.sigma, x.percent, y.mean, 1e3 * y.sigma, y.percent);
    };
    for (std::size_t p = 0; p < chou1986_places().size(); ++p) {
        const Eigen::Vector2d& place = chou1986_places()[p];
        std::array<std::vector<double>, 4> values;
        double bound = 0;
        int count = 0;
        for (const Chou1986Trial& t : report.trials) {
            if (t.place != static_cast<int>(p)) continue;
            for (std::size_t k = 0; k < 2; ++k) {
                const auto axis = static_cast<Eigen::Index>(k);
                if (t.published) values[k].push_back(t.ceiling_distance * t.published->place[axis]);
                if (t.ours) values[2 + k].push_back(t.ceiling_distance * t.ours->view.place[axis]);
            }
            bound += (t.bound(3, 3) + t.bound(4, 4)) * t.ceiling_distance * t.ceiling_distance;
            ++count;
        }
        text += fmt::format("  {:5.2f}  {:5.2f}    |{}|{}| {:6.2f}\n", place.x(), place.y(),
                            columns(coordinate_of(values[0], place.x()), coordinate_of(values[1], place.y()), report.options.published),
                            columns(coordinate_of(values[2], place.x()), coordinate_of(values[3], place.y())), 1e3 * std::sqrt(bound / std::max(count, 1)));
    }
    text +=
        fmt::format("  roomfix: {} fixes, {} lost; error of a single picture over the distance to the corner: mean {:.4f} %, largest {:.3f} %, rms {:.4f} %\n",
                    static_cast<int>(report.trials.size()) - report.lost(), report.lost(), 100 * report.mean_error(), 100 * report.largest_error(),
                    100 * report.rms_error());
    text += fmt::format("    rms / bound {:.2f}; rotation: mean {:.4f} deg, rms / bound {:.2f}\n", report.rms_error() / report.bound_rms(),
                        degrees(report.mean_rotation()), report.rotation_rms() / report.rotation_bound());
    const NeesBand band = report.nees_band();
    text += fmt::format("    mean NEES {:.2f} (5 unknowns), truthful covariances give {:.2f} to {:.2f} in 95 % of such experiments ({})\n", report.mean_nees(),
                        band.low, band.high, report.options.board.shots > 0 ? fmt::format("{} lenses", report.options.seeds) : "the lens is known");
    if (report.options.published) {
        text += fmt::format("  as published: {} fixes, {} lost; mean {:.3f} %, largest {:.2f} %\n",
                            static_cast<int>(report.trials.size()) - report.published_lost(), report.published_lost(), 100 * report.published_mean_error(),
                            100 * report.published_largest_error());
    }
    return text;
}

LineChart chou1986_error_study() {
    LineChart chart;
    chart.title = "Chou and Tsai 1986: what errors in the picture do to the place";
    chart.x_label = "distance X_c from one wall, m (Y_c = 2 m from the other, Z_c = 2 m below the ceiling)";
    chart.y_label = "error, % of the coordinate";
    chart.logarithmic = true;
    chart.curves = {{"X_c, 0.1 deg on each line's angle", {}, false},
                    {"Y_c, 0.1 deg on each line's angle", {}, false},
                    {"X_c, image centre 1 px off", {}, true},
                    {"Y_c, image centre 1 px off", {}, true}};
    const double f = room_camera().fx;
    for (double x = 0.2; x <= 4.001; x += 0.05) {
        const Eigen::Vector3d position(x, 2, -2);
        const Eigen::Isometry3d camera = looking_at(position, {0, 0, -0.5});  // at the walls' edge, the corner above the middle of the picture
        const CornerView truth{camera.linear(), position.head<2>() / 2};
        const auto rays = corner_rays(truth, right_angle);
        if (!rays) continue;
        Eigen::Vector2d by_angles = Eigen::Vector2d::Zero();
        Eigen::Vector2d by_centre = Eigen::Vector2d::Zero();
        const auto add = [&](const CornerRays& wrong, Eigen::Vector2d& squares) {
            const auto view = chou1986_view(wrong);
            if (view) squares += (view->place - truth.place).cwiseAbs2();
        };
        for (std::size_t line = 0; line < 3; ++line) {
            CornerRays wrong = *rays;
            wrong.directions[line] = Eigen::Rotation2Dd(radians(0.1)) * wrong.directions[line];
            add(wrong, by_angles);
        }
        for (const int axis : {0, 1}) {
            CornerRays wrong = *rays;
            wrong.corner[axis] += 1 / f;
            add(wrong, by_centre);
        }
        const auto percent = [&](double square, double coordinate) { return 100 * std::sqrt(square) / coordinate; };
        chart.curves[0].points.emplace_back(x, percent(by_angles.x(), truth.place.x()));
        chart.curves[1].points.emplace_back(x, percent(by_angles.y(), truth.place.y()));
        chart.curves[2].points.emplace_back(x, percent(by_centre.x(), truth.place.x()));
        chart.curves[3].points.emplace_back(x, percent(by_centre.y(), truth.place.y()));
    }
    return chart;
}

namespace {

/// A camera that takes pictures of rooms and looks for corners in them.
struct Studio {
    CameraModel model = room_camera();
    RoomRenderer renderer;
    CornerObserver observer{model, {right_angle}};
    LumaImage frame;
    CornerResult seen;

    explicit Studio(std::uint64_t seed) : renderer(model, room_sensor(), {}, seed) {}
    void look(const RoomShot& shot, std::uint64_t index) {
        renderer.render(shot.scene, shot.map_from_camera, shot.light, index, frame);
        observer.observe(frame, {}, seen);
    }
};

}  // namespace

ClutterReport run_cluttered(int pictures, std::uint64_t seed, Walls walls, const std::function<void(double)>& progress) {
    ClutterReport report;
    Studio studio(seed);
    Random random(seed);
    for (int i = 0; i < pictures; ++i) {
        const RoomShot shot = cluttered_shot(random, walls);
        studio.look(shot, static_cast<std::uint64_t>(i));
        auto lengths = visible_edges(shot, studio.model, studio.renderer, visible_contrast);
        std::sort(lengths.begin(), lengths.end());
        const bool visible = lengths[2] > 80 && lengths[1] > 60 && lengths[0] > 20;
        ++report.pictures;
        report.visible += visible;
        const auto& corners = studio.seen.corners;
        if (corners.empty()) {
            report.none += visible;
        } else {
            const CornerView truth = true_view(shot);
            const double error = (corners[0].view.place - truth.place).norm() / std::sqrt(1 + truth.place.squaredNorm());
            report.good += visible && error < 0.01;
            if (error > 0.05 && corners[0].weight > 0.5) {
                if (report.wrong++ == 0) report.first_wrong = fmt::format("first wrong: picture {}, off by {:.1f} %", i, 100 * error);
            }
        }
        if (progress) progress((i + 1.0) / pictures);
    }
    return report;
}

int run_cornerless(int pictures, std::uint64_t seed, Walls walls, const std::function<void(double)>& progress) {
    Studio studio(seed);
    Random random(seed);
    int found = 0;
    for (int i = 0; i < pictures; ++i) {
        studio.look(cornerless_shot(random, walls), static_cast<std::uint64_t>(i));
        found += !studio.seen.corners.empty();
        if (progress) progress((i + 1.0) / pictures);
    }
    return found;
}

}  // namespace roomfix
