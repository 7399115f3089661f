#include "roomfix/evaluate/tracker_experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/base/random_vector.hpp"
#include "roomfix/estimate/tracker.hpp"
#include "roomfix/evaluate/consistency.hpp"
#include "roomfix/evaluate/tracking_bound.hpp"
#include "roomfix/smooth/camera_errors.hpp"
#include "roomfix/smooth/smoother.hpp"

namespace roomfix {
namespace {

template <int N>
Eigen::Matrix<double, N, 1> drawn(const Eigen::Matrix<double, N, N>& covariance, Random& random) {
    const Eigen::LDLT<Eigen::Matrix<double, N, N>> factor(covariance);
    Eigen::Matrix<double, N, 1> z;
    for (int i = 0; i < N; ++i) z[i] = random.normal() * std::sqrt(std::max(factor.vectorD()[i], 0.0));
    return factor.transpositionsP().transpose() * (factor.matrixL() * z);
}

/// One drive: what is true, what is seen of it, and what the tracker makes of that.
class Drive1 {
public:
    explicit Drive1(const DriveOptions& options)
        : options_(options),
          random_(options.seed),
          site_(hall_site(options.senses)),
          tracker_(site_, {}),
          models_(site_, {}),
          motion_(drive_through_hall(options.seconds, models_.motion[0], random_)),
          bound_(models_, 0, [this](Nanoseconds time) { return true_states(time); }) {
        for (int c = 0; c < 2; ++c) {
            const auto& known = std::get<KnownPose>(site_.cameras[static_cast<std::size_t>(c)].placement).map_from_camera;
            error_.push_back(drawn<6>(known.covariance, random_));
        }
        for (int c = 2; c < 4; ++c) {
            const auto& known = std::get<Mount>(site_.cameras[static_cast<std::size_t>(c)].placement).robot_from_camera;
            error_.push_back(drawn<6>(known.covariance, random_));
            mount_.push_back(perturbed(known.pose, error_.back()));
        }
        for (std::size_t i = 0; i < site_.landmarks.size(); ++i) landmark_error_.push_back(site_.landmarks[i].sigma * normal3(random_));
        for (std::size_t i = 0; i < site_.corners.size(); ++i) corner_error_.push_back(site_.corners[i].sigma * normal3(random_));
        const WheelOdometry& wheels = *site_.robots[0].odometry;
        scale_ = options.scale_error != 0 ? options.scale_error : random_.normal(wheels.scale_sigma);
        turn_scale_ = random_.normal(OdometryPrior{}.turn_scale_sigma);
        drift_ = options.drift_error != 0 ? options.drift_error : random_.normal(wheels.drift_sigma);
        if (options.smoothed) tracker_.keep_history();
    }

    std::vector<TrackerSample> run() {
        // 100 moments a second; each sense speaks at its own rate and phase.
        for (int i = 0; i * 0.01 < options_.seconds; ++i) {
            const double t = i * 0.01;
            const HallSenses& s = options_.senses;
            if (options_.smoothed && i % 5 == 4) keep_fix(t);
            const bool sees = t < options_.blind_from;
            if (s.odometry && i % 5 == 0) roll(t);
            if (!sees) continue;
            for (int c = 0; c < 2 && s.cameras; ++c) {
                if (i % 10 == 3 + 4 * c) watch(c, t);
            }
            if (s.ceiling && i % 10 == 1) look_up(t);
            if (s.corners && i % 10 == 6) look_for_corner(t);
            for (int b = 0; b < 6 && s.ranges; ++b) {
                if (i % 20 == 2 + 3 * b) hear(b, t);
            }
        }
        if (options_.smoothed) take_smoothed();
        return std::move(samples_);
    }

    /// After run(): what the drive tells of the cameras.
    std::vector<CalibratedByDrive> calibrations() const {
        std::vector<CalibratedByDrive> all;
        for (const SixErrors& six : camera_errors_of(tracker_, fixes_)) {
            const std::string& id = tracker_.models().source_name(six.source);
            const auto place = std::find_if(site_.cameras.begin(), site_.cameras.end(), [&](const SiteCamera& c) { return c.id == id; });
            const auto* mount = std::get_if<Mount>(&place->placement);
            const Matrix6d before = mount ? mount->robot_from_camera.covariance : std::get<KnownPose>(place->placement).map_from_camera.covariance;
            const CalibrationRoot root = mount ? calibration_root(camera_on_robot(*place, *mount)) : fixed_view(*place)->calibration;
            const LearnedCalibration learned = learned_calibration(before, {}, root, six.mean, six.covariance);
            all.push_back({id, error_[static_cast<std::size_t>(place - site_.cameras.begin())], learned.pose, learned.pose_covariance, before});
        }
        return all;
    }

    /// Samples are taken between the events, when all that is earlier has been told.
    void sample(double t) {
        if (t < 3 || t + 1e-9 < next_sample_) return;
        next_sample_ += 0.5;
        TrackerSample s;
        s.time = t;
        const StateVector truth = motion_.at(t);
        s.truth = {truth[0], truth[1], wrap_angle(truth[2])};
        for (const Fix& fix : tracker_.fixes(from_seconds(t))) s.take(fix);
        if (options_.smoothed) keep_fix(t);
        if (bound_.started()) bound_.predict_to(from_seconds(t), models_.driven[0]);
        s.bound = bound_.belief().pose_covariance();
        samples_.push_back(s);
    }

private:
    void keep_fix(double t) {
        const auto fixes = tracker_.fixes(from_seconds(t));
        fixes_.insert(fixes_.end(), fixes.begin(), fixes.end());
    }

    /// In the samples, what is known now of those moments.
    void take_smoothed() {
        const auto fixes = smooth(tracker_, fixes_).fixes;
        for (TrackerSample& s : samples_) {
            const auto fix = std::find_if(fixes.begin(), fixes.end(), [&](const Fix& f) { return f.time == from_seconds(s.time); });
            if (fix != fixes.end()) s.take(*fix);
        }
    }

    Pose2 truth(double t) const {
        const StateVector s = motion_.at(t);
        return {s[0], s[1], s[2]};
    }

    /// Wheels with a constant scale error and drift, and noise as the model says.
    void roll(double t) {
        const Pose2 now = truth(t);
        const OdometryNoise& noise = models_.settings.odometry;
        if (t > 0) {
            const Pose2 before = truth(rolled_until_);
            const double dt = t - rolled_until_;
            Eigen::Vector2d way = Eigen::Rotation2Dd(-before.yaw) * Eigen::Vector2d(now.x - before.x, now.y - before.y);
            double turned = now.yaw - before.yaw;
            const double length = way.norm();
            const double rest = noise.still * noise.still * dt;
            // true = (1 + scale) measured: what is measured is the truth with the errors taken out.
            way += normal_vector<2>(random_, {std::sqrt(noise.along * noise.along * length + rest), std::sqrt(noise.across * noise.across * length + rest)});
            turned += random_.normal(std::sqrt(noise.turn_per_metre * noise.turn_per_metre * length +
                                               noise.turn_per_radian * noise.turn_per_radian * std::abs(turned) + noise.still_turn * noise.still_turn * dt));
            const double shown = (turned - drift_ * dt) / (1 + turn_scale_);
            way = Eigen::Rotation2Dd(0.5 * (shown - turned)) * way / (1 + scale_);
            turned = shown;
            const Eigen::Vector2d step = Eigen::Rotation2Dd(wheels_.yaw) * way;
            wheels_ = {wheels_.x + step.x(), wheels_.y + step.y(), wheels_.yaw + turned};
        }
        rolled_until_ = t;
        tracker_.observe({from_seconds(t), 0, wheels_});
        models_.driven[0].add(from_seconds(t), wheels_);
        // Steps that end here are known only now: samples belong to these moments.
        sample(t);
    }

    /// A fixed camera: its calibration's error moves all it sees, noise is on top.
    void watch(int c, double t) {
        const SiteCamera& camera = site_.cameras[static_cast<std::size_t>(c)];
        const View view{camera.model, std::get<KnownPose>(camera.placement).map_from_camera};
        const Pose2 at = truth(t);
        const auto pixel = project_map_point(view, {at.x, at.y, 0});
        if (!options_.senses.odometry) sample(t);
        if (!pixel || !camera.model.contains(*pixel, 20)) return;
        const auto floor = pixel_to_plane(view, *pixel, 0);
        if (!floor) return;
        Eigen::Matrix<double, 3, 6> by_camera;
        by_camera.topRows<2>() = -floor->by_pose;  // what is seen moves against the camera
        by_camera.row(2) << 0, 0, 0, 0, 0, -1;
        PoseObservation seen;
        seen.by_calibration = by_camera * view.calibration.topRows<6>();
        Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
        noise.topLeftCorner<2, 2>() = 0.6 * 0.6 * floor->by_pixel * floor->by_pixel.transpose() + 1e-6 * Eigen::Matrix2d::Identity();
        noise(2, 2) = 0.015 * 0.015;
        seen.covariance = by_camera * view.map_from_camera.covariance * by_camera.transpose() + noise;
        const Eigen::Vector3d error = by_camera * error_[static_cast<std::size_t>(c)] + drawn<3>(noise, random_);
        seen.pose = {at.x + error.x(), at.y + error.y(), wrap_angle(at.yaw + error.z())};
        tracker_.observe(from_seconds(t), camera.id, {&seen, 1});

        learn_for_bound({from_seconds(t), models_.source(camera.id), seen}, seen.covariance);
    }

    /// `covariance`: about how well the pose is known from this alone.
    void learn_for_bound(const Measured& measured, const Eigen::Matrix3d& covariance) {
        if (!bound_.started()) bound_.start(measured.time, 1e4 * covariance);
        bound_.predict_to(measured.time, models_.driven[0]);
        bound_.learn(measured);
    }

    StateVector true_states(Nanoseconds time) const {
        StateVector states = motion_.at(to_seconds(time));
        states[state_scale] = scale_;
        states[state_turn_scale] = turn_scale_;
        states[state_drift] = drift_;
        return states;
    }

    PlaceProposal place_near(double t, double sigma, double yaw_sigma) {
        const Pose2 at = truth(t);
        PlaceProposal place;
        place.covariance = Eigen::Vector3d(sigma * sigma, sigma * sigma, yaw_sigma * yaw_sigma).asDiagonal();
        const Eigen::Vector3d error = Eigen::Vector3d(sigma, sigma, yaw_sigma).cwiseProduct(normal3(random_));
        place.pose = {at.x + error.x(), at.y + error.y(), wrap_angle(at.yaw + error.z())};
        return place;
    }

    void look_up(double t) {
        if (!options_.senses.odometry) sample(t);
        constexpr double sigma = 0.1;  // px
        const SiteCamera& camera = site_.cameras[2];
        const CameraOnRobot real{camera.model, {mount_[0], Matrix6d::Zero()}};
        LandmarkSighting sighting;
        std::vector<std::size_t> which;
        for (std::size_t i = 0; i < site_.landmarks.size(); ++i) {
            LandmarkObservation seen;
            for (const Eigen::Vector3d& point : models_.landmark_points[i]) {
                const auto pixel = predict_point(real, truth(t), point + landmark_error_[i]);
                if (!pixel || !camera.model.contains(*pixel, 4)) break;
                seen.points.push_back({*pixel + sigma * normal2(random_), sigma * sigma * Eigen::Matrix2d::Identity()});
            }
            if (seen.points.size() != 3) continue;
            seen.shapes.push_back(0);
            sighting.landmarks.push_back(seen);
            which.push_back(i);
        }
        if (sighting.landmarks.empty()) return;
        sighting.proposals.push_back(place_near(t, 0.03, 0.03));
        tracker_.observe(from_seconds(t), camera.id, sighting);

        for (std::size_t k = 0; k < which.size(); ++k) {
            const SeenLandmark seen{sighting.landmarks[k], static_cast<int>(which[k])};
            learn_for_bound({from_seconds(t), models_.source(camera.id), seen}, sighting.proposals[0].covariance);
        }
    }

    void look_for_corner(double t) {
        if (!options_.senses.odometry) sample(t);
        const SiteCamera& camera = site_.cameras[3];
        const Eigen::Isometry3d map_from_camera = map_from_robot(truth(t)) * mount_[1];
        for (std::size_t i = 0; i < site_.corners.size(); ++i) {
            const SiteCorner& corner = site_.corners[i];
            const Eigen::Vector3d vertex = corner.position + corner_error_[i];
            const auto pixel = project(camera.model, map_from_camera.inverse() * vertex);
            if (!pixel || !camera.model.contains(*pixel, 20)) continue;
            CornerObservation seen;
            const Eigen::Matrix3d corner_from_map = Eigen::AngleAxisd(-corner.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
            const Eigen::Vector3d at = corner_from_map * (map_from_camera.translation() - vertex);
            const double far = at.norm() / -at.z();
            Vector5d sigma;
            sigma << 0.003, 0.003, 0.002, 0.003 * far, 0.003 * far;
            seen.covariance = sigma.cwiseAbs2().asDiagonal();
            const Vector5d error = drawn<5>(seen.covariance, random_);
            seen.view.corner_from_camera = exponential_rotation(error.head<3>()) * corner_from_map * map_from_camera.linear();
            seen.view.place = at.head<2>() / -at.z() + error.tail<2>();
            CornerSighting sighting;
            sighting.corners.push_back(seen);
            sighting.proposals.push_back(place_near(t, 0.05, 0.03));
            tracker_.observe(from_seconds(t), camera.id, sighting);

            learn_for_bound({from_seconds(t), models_.source(camera.id), SeenCorner{seen, static_cast<int>(i)}}, sighting.proposals[0].covariance);
            return;
        }
    }

    void hear(int b, double t) {
        if (!options_.senses.odometry) sample(t);
        const Receiver& receiver = *site_.robots[0].receiver();
        const Eigen::Vector3d& beacon = site_.beacons[static_cast<std::size_t>(b)].position;
        const PredictedRange exact = predict_range(truth(t), receiver.position, beacon);
        const LateModel& late = models_.settings.late;
        double range = exact.range + random_.normal(receiver.sigma);
        if (random_.uniform() < late.share) range -= late.mean * std::log(random_.uniform());
        if (!bound_.started() && !(options_.senses.cameras || options_.senses.ceiling || options_.senses.corners)) {
            PlaceSighting places;
            places.proposals.push_back(place_near(t, 0.3, 0.3));
            places.proposals[0].yaw_known = false;
            tracker_.propose(from_seconds(t - 0.001), "start", places);
            Eigen::Matrix3d spread = places.proposals[0].covariance;
            spread(2, 2) = unknown_yaw_variance;
            bound_.start(from_seconds(t), spread);
        }
        const RangeObservation heard{from_seconds(t), 0, b, range, receiver.sigma};
        tracker_.observe(heard);
        if (!bound_.started()) return;
        bound_.predict_to(heard.time, models_.driven[0]);
        bound_.learn({heard.time, models_.range_source, heard});
    }

    DriveOptions options_;
    Random random_;
    Site site_;
    Tracker tracker_;
    TrackingModels models_;
    TrueMotion motion_;
    TrackingBound bound_;
    std::vector<Vector6d> error_;  // of all four cameras
    std::vector<Eigen::Isometry3d> mount_;
    std::vector<Eigen::Vector3d> landmark_error_, corner_error_;
    double scale_ = 0, turn_scale_ = 0, drift_ = 0;
    double rolled_until_ = 0;
    Pose2 wheels_;
    double next_sample_ = 3;
    std::vector<TrackerSample> samples_;
    std::vector<Fix> fixes_;  // all, for smoothing
};

}  // namespace

void TrackerSample::take(const Fix& known) {
    found = known.status != FixStatus::none;
    yaw_known = known.yaw_known;
    fix = known.pose;
    covariance = known.covariance;
}

std::vector<CalibratedByDrive> calibrations_by_drive(DriveOptions options) {
    options.smoothed = true;
    Drive1 drive(options);
    drive.run();
    return drive.calibrations();
}

SiteCalibrationResult measure_site_calibration(const std::string& name, const HallSenses& senses, double seconds, int runs, std::uint64_t seed,
                                               const std::function<void(double)>& progress) {
    SiteCalibrationResult result;
    result.name = name;
    int inside = 0;
    double nees = 0, before = 0, now = 0;
    for (int i = 0; i < runs; ++i) {
        DriveOptions options;
        options.senses = senses;
        options.seconds = seconds;
        options.seed = mix64(seed * 1000003 + static_cast<std::uint64_t>(i));
        for (const CalibratedByDrive& camera : calibrations_by_drive(options)) {
            const Vector6d error = camera.found - camera.truth;
            for (int k = 0; k < 6; ++k) inside += std::abs(error[k]) < 1.96 * std::sqrt(camera.covariance(k, k));
            nees += error.dot(camera.covariance.ldlt().solve(error));
            before += camera.truth.tail<3>().squaredNorm();
            now += error.tail<3>().squaredNorm();
            ++result.cameras;
        }
        if (progress) progress((i + 1.0) / runs);
    }
    const double count = std::max(result.cameras, 1);
    result.coverage = inside / (6 * count);
    result.nees = nees / count;
    result.turn_before = std::sqrt(before / count);
    result.turn_now = std::sqrt(now / count);
    return result;
}

std::vector<TrackerSample> simulated_drive(const DriveOptions& options) { return Drive1(options).run(); }

ConsistencyResult measure_consistency(const std::string& name, const HallSenses& senses, int runs, std::uint64_t seed,
                                      const std::function<void(double)>& progress, bool smoothed) {
    ConsistencyResult result;
    result.name = name;
    result.runs = runs;
    result.dimensions = senses.cameras || senses.ceiling || senses.corners || senses.odometry ? 3 : 2;
    int judged = 0;
    double squares = 0, yaw_squares = 0, bounds = 0, yaw_bounds = 0;
    for (int i = 0; i < runs; ++i) {
        DriveOptions options;
        options.senses = senses;
        options.seed = mix64(seed * 1000003 + static_cast<std::uint64_t>(i));
        options.smoothed = smoothed;
        const auto samples = simulated_drive(options);
        for (std::size_t k = 0; k < samples.size(); ++k) {
            const TrackerSample& s = samples[k];
            ++result.samples;
            if (!s.found) {
                ++result.lost;
                continue;
            }
            const Eigen::Vector3d error = pose_error(s.fix, s.truth, 2 * std::numbers::pi);
            squares += error.head<2>().squaredNorm();
            yaw_squares += error.z() * error.z();
            bounds += s.bound.topLeftCorner<2, 2>().trace();
            yaw_bounds += s.bound(2, 2);
            // The tracker knows most at the end; the smoother least at the ends.
            if (k != (smoothed ? samples.size() / 2 : samples.size() - 1)) continue;
            ++judged;
            const Eigen::Matrix2d place = s.covariance.topLeftCorner<2, 2>();
            result.nees += result.dimensions == 3 ? nees(error, s.covariance) : error.head<2>().dot(place.inverse() * error.head<2>());
        }
        if (progress) progress((i + 1.0) / runs);
    }
    const int found = std::max(result.samples - result.lost, 1);
    result.nees /= std::max(judged, 1);
    const double spread = 1.96 * std::sqrt(2.0 * result.dimensions / std::max(judged, 1));
    result.nees_low = result.dimensions - spread;
    result.nees_high = result.dimensions + spread;
    result.rmse = std::sqrt(squares / found);
    result.yaw_rmse = std::sqrt(yaw_squares / found);
    result.bound = std::sqrt(bounds / found);
    result.yaw_bound = std::sqrt(yaw_bounds / found);
    return result;
}

std::vector<std::pair<std::string, HallSenses>> all_senses() {
    std::vector<std::pair<std::string, HallSenses>> all;
    for (const bool odometry : {false, true}) {
        const std::string with = odometry ? " + odometry" : "";
        all.emplace_back("cameras" + with, HallSenses{true, false, false, false, odometry});
        all.emplace_back("ceiling" + with, HallSenses{false, true, false, false, odometry});
        all.emplace_back("corner" + with, HallSenses{false, false, true, false, odometry});
        all.emplace_back("ranges" + with, HallSenses{false, false, false, true, odometry});
        all.emplace_back("all" + with, HallSenses{true, true, true, true, odometry});
    }
    return all;
}

double blind_coverage(int runs, std::uint64_t seed, double scale_error, double drift_error) {
    int inside = 0;
    for (int i = 0; i < runs; ++i) {
        Random random(mix64(seed * 7919 + static_cast<std::uint64_t>(i)));
        DriveOptions options;
        options.senses = {true, false, false, false, true};
        options.seconds = 22;
        options.blind_from = 12;
        options.seed = random.bits();
        options.scale_error = random.uniform() < 0.5 ? scale_error : -scale_error;
        options.drift_error = random.uniform() < 0.5 ? drift_error : -drift_error;
        const auto samples = simulated_drive(options);
        const TrackerSample& last = samples.back();
        if (!last.found) continue;
        const Eigen::Vector2d error(last.fix.x - last.truth.x, last.fix.y - last.truth.y);
        const Eigen::Matrix2d place = last.covariance.topLeftCorner<2, 2>();
        inside += error.dot(place.inverse() * error) < 5.991;
    }
    return static_cast<double>(inside) / runs;
}

}  // namespace roomfix
