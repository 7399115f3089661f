// import roomfix: a site, single pictures, the tracker fed by hand, sessions replayed. What it offers is documented in roomfix/__init__.pyi.
#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "numpy_picture.hpp"
#include "roomfix/base/worker_pool.hpp"
#include "roomfix/connect/fix_json.hpp"
#include "roomfix/estimate/tracker.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/pipeline/background_source.hpp"
#include "roomfix/pipeline/replay.hpp"
#include "roomfix/pipeline/single_shot.hpp"
#include "roomfix/site/load_site.hpp"
#include "roomfix/smooth/smoother.hpp"
#include "roomfix/version.hpp"

namespace roomfix {
namespace {

namespace py = pybind11;

/// roomfix.Error in Python.
struct Failure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

template <class T>
T unwrapped(Result<T>&& result) {
    if (!result) throw Failure(result.error().message);
    return std::move(*result);
}

void check(const Result<void>& result) {
    if (!result) throw Failure(result.error().message);
}

/// The place of a name among things that have an `id`; throws where there is none of that name.
template <class List>
int index_of(const List& list, const std::string& id, const char* what) {
    for (std::size_t i = 0; i < list.size(); ++i) {
        if (list[i].id == id) return static_cast<int>(i);
    }
    throw Failure(fmt::format("there is no {} '{}' in the site", what, id));
}

template <class List>
std::vector<std::string> ids_of(const List& list) {
    std::vector<std::string> ids;
    for (const auto& one : list) ids.push_back(one.id);
    return ids;
}

Eigen::Vector3d vector_of(const Pose2& pose) { return {pose.x, pose.y, pose.yaw}; }

/// Single pictures of one camera.
class Camera {
public:
    Camera(const Site& site, const std::string& camera, const std::vector<std::string>& background)
        : site_(site), camera_(site_.cameras[static_cast<std::size_t>(index_of(site_.cameras, camera, "camera"))]) {
        ShotOptions options;
        options.background = background;
        shot_ = unwrapped(prepare_shot(site_, camera_, options));
    }

    std::vector<Fix> fix(const py::array& array, const std::string& order) {
        const NumpyPicture picture = picture_of(array, order);
        check_size(picture.grey);
        const py::gil_scoped_release others_may_run;
        return shot_.fixes("", picture.view());
    }

private:
    void check_size(const LumaImage& grey) const {
        if (grey.width() == camera_.model.width && grey.height() == camera_.model.height) return;
        throw Failure(fmt::format("camera {}: the picture is {} x {} pixels, the site says {} x {}", camera_.id, grey.width(), grey.height(),
                                  camera_.model.width, camera_.model.height));
    }

    Site site_;
    SiteCamera camera_;
    Shot shot_;
};

/// A tracker that is fed by hand; each call gives the fixes that it made due.
class HandTracker {
public:
    HandTracker(const Site& site, const std::vector<std::string>& background) : tracker_(unwrapped(SiteTracker::create(site))), pool_(hardware_threads()) {
        check(learn_backgrounds(*tracker_, background, {}));
        tracker_->on_fixes([this](const FixBatch& batch) {
            const std::lock_guard lock(mutex_);
            due_.insert(due_.end(), batch.given.begin(), batch.given.end());
        });
    }

    std::vector<Fix> frame(const std::string& camera, const py::array& array, double time, const std::string& order) {
        return frames({{camera, array}}, time, order);
    }

    std::vector<Fix> frames(const std::map<std::string, py::array>& arrays, double time, const std::string& order) {
        std::vector<NumpyPicture> pictures;
        std::vector<std::size_t> cameras;
        for (const auto& [camera, array] : arrays) {
            cameras.push_back(camera_index(camera));
            pictures.push_back(picture_of(array, order));
        }
        std::vector<CameraFrame> frames;
        for (std::size_t i = 0; i < pictures.size(); ++i) frames.push_back({cameras[i], pictures[i].view(), from_seconds(time)});
        const py::gil_scoped_release others_may_run;
        check(tracker_->process(frames, pool_));
        return taken();
    }

    std::vector<Fix> range(const std::string& robot, const std::string& beacon, double range, double time, std::optional<double> sigma,
                           const std::string& receiver) {
        const Site& site = tracker_->site();
        RangeObservation heard;
        heard.time = from_seconds(time);
        heard.robot = index_of(site.robots, robot, "robot");
        heard.beacon = index_of(site.beacons, beacon, "beacon");
        heard.range = range;
        const std::vector<Receiver>& receivers = site.robots[static_cast<std::size_t>(heard.robot)].receivers;
        if (receivers.empty()) throw Failure(fmt::format("robot {} has no receiver: give it one in the site", robot));
        heard.receiver = receiver.empty() ? 0 : index_of(receivers, receiver, "receiver");
        heard.sigma = sigma.value_or(receivers[static_cast<std::size_t>(heard.receiver)].sigma);
        RangeBatch batch;
        batch.ranges.push_back(heard);
        return processed(batch);
    }

    std::vector<Fix> odometry(const std::string& robot, double x, double y, double yaw, double time) {
        OdometryBatch batch;
        batch.poses.push_back({from_seconds(time), index_of(tracker_->site().robots, robot, "robot"), {x, y, yaw}});
        return processed(batch);
    }

    std::vector<Fix> sighting(const std::string& robot, const std::optional<std::string>& landmark, std::optional<double> range, std::optional<double> bearing,
                              double time) {
        const Site& site = tracker_->site();
        SightingObservation seen;
        seen.time = from_seconds(time);
        seen.robot = index_of(site.robots, robot, "robot");
        if (landmark) seen.landmark = index_of(site.landmarks, *landmark, "landmark");
        const auto& detector = site.robots[static_cast<std::size_t>(seen.robot)].detector;
        if (!detector) throw Failure(fmt::format("robot {} has no detector: give it one in the site", robot));
        seen.range = range;
        seen.bearing = bearing;
        seen.range_sigma = detector->range_sigma;
        seen.bearing_sigma = detector->bearing_sigma;
        SightingBatch batch;
        batch.sightings.push_back(seen);
        return processed(batch);
    }

    std::vector<Fix> fixes(double time) const { return tracker_->fixes(from_seconds(time)); }
    std::map<std::string, std::string> camera_messages() const {
        std::map<std::string, std::string> messages;
        for (const CameraState& state : tracker_->camera_states()) messages[state.id] = state.status + (state.message.empty() ? "" : ": ") + state.message;
        return messages;
    }

private:
    std::size_t camera_index(const std::string& id) const {
        for (std::size_t i = 0; i < tracker_->cameras(); ++i) {
            if (tracker_->camera(i).id == id) return i;
        }
        throw Failure(fmt::format("there is no camera '{}' in the site that finds robots", id));
    }

    template <class Batch>
    std::vector<Fix> processed(const Batch& batch) {
        const py::gil_scoped_release others_may_run;
        tracker_->process(batch);
        return taken();
    }

    std::vector<Fix> taken() {
        const std::lock_guard lock(mutex_);
        return std::exchange(due_, {});
    }

    std::unique_ptr<SiteTracker> tracker_;
    WorkerPool pool_;
    std::mutex mutex_;
    std::vector<Fix> due_;
};

/// What `roomfix replay` writes, as a list.
std::vector<Fix> replay_session(const std::filesystem::path& session, const std::vector<std::string>& background, std::optional<int> threads, bool smoothed) {
    const Site site = unwrapped(load_session(session));
    ReplaySettings settings;
    settings.threads = threads.value_or(hardware_threads());
    settings.background = background;
    settings.keep_history = smoothed;
    const Replayed replayed = unwrapped(replay(site, settings));
    return smoothed ? smooth(replayed.tracker->tracker(), replayed.fixes, {}).fixes : replayed.fixes;
}

}  // namespace
}  // namespace roomfix

PYBIND11_MODULE(_roomfix, module) {
    using namespace roomfix;
    namespace py = pybind11;
    using py::arg;
    const std::vector<std::string> none;
    module.attr("__version__") = version;
    py::register_exception<Failure>(module, "Error", PyExc_ValueError);

    py::class_<Site>(module, "Site")
        .def_property_readonly("name", [](const Site& site) { return site.name; })
        .def_property_readonly("cameras", [](const Site& site) { return ids_of(site.cameras); })
        .def_property_readonly("robots", [](const Site& site) { return ids_of(site.robots); })
        .def_property_readonly("beacons", [](const Site& site) { return ids_of(site.beacons); })
        .def_property_readonly("landmarks", [](const Site& site) { return ids_of(site.landmarks); })
        .def("__repr__",
             [](const Site& site) { return fmt::format("<roomfix.Site '{}': {} cameras, {} robots>", site.name, site.cameras.size(), site.robots.size()); });
    module.def(
        "load_site", [](const std::filesystem::path& file) { return unwrapped(load_session(file)); }, arg("file"));

    module.def(
        "load_grey", [](const std::filesystem::path& file) { return array_of(unwrapped(load_luma(file))); }, arg("file"));

    py::class_<PoseHypothesis>(module, "Hypothesis")
        .def_property_readonly("pose", [](const PoseHypothesis& h) { return vector_of(h.pose); })
        .def_readonly("weight", &PoseHypothesis::weight);
    py::class_<Fix>(module, "Fix")
        .def_property_readonly("time", [](const Fix& fix) { return to_seconds(fix.time); })
        .def_readonly("time_ns", &Fix::time)
        .def_readonly("robot", &Fix::robot)
        .def_readonly("unknown", &Fix::unknown)
        .def_property_readonly("status", [](const Fix& fix) { return name_of(fix.status); })
        .def_property_readonly("pose", [](const Fix& fix) { return vector_of(fix.pose); })
        .def_readonly("yaw_known", &Fix::yaw_known)
        .def_property_readonly("covariance", [](const Fix& fix) { return Eigen::Matrix3d(fix.covariance); })
        .def_readonly("sources", &Fix::sources)
        .def_readonly("reason", &Fix::reason)
        .def_readonly("identity", &Fix::identity)
        .def_readonly("hypotheses", &Fix::hypotheses)
        .def("__repr__", [](const Fix& fix) {
            return fmt::format("<roomfix.Fix {} {} at {:.3f} {:.3f} m, {:.1f} deg>", fix.robot.empty() ? "nobody" : fix.robot, name_of(fix.status), fix.pose.x,
                               fix.pose.y, degrees(fix.pose.yaw));
        });

    py::class_<Camera>(module, "Camera")
        .def(py::init<const Site&, const std::string&, const std::vector<std::string>&>(), arg("site"), arg("camera"), arg("background") = none)
        .def("fix", &Camera::fix, arg("picture"), arg("order") = "rgb");

    py::class_<HandTracker>(module, "Tracker")
        .def(py::init<const Site&, const std::vector<std::string>&>(), arg("site"), arg("background") = none)
        .def("frame", &HandTracker::frame, arg("camera"), arg("picture"), arg("time"), arg("order") = "rgb")
        .def("frames", &HandTracker::frames, arg("pictures"), arg("time"), arg("order") = "rgb")
        .def("range", &HandTracker::range, arg("robot"), arg("beacon"), arg("range"), arg("time"), arg("sigma") = py::none(), arg("receiver") = "")
        .def("odometry", &HandTracker::odometry, arg("robot"), arg("x"), arg("y"), arg("yaw"), arg("time"))
        .def("sighting", &HandTracker::sighting, arg("robot"), arg("landmark") = py::none(), arg("range") = py::none(), arg("bearing") = py::none(),
             py::kw_only(), arg("time"))
        .def("fixes", &HandTracker::fixes, arg("time"))
        .def_property_readonly("cameras", &HandTracker::camera_messages);

    module.def("replay", &replay_session, arg("session"), arg("background") = none, arg("threads") = py::none(), arg("smooth") = false,
               py::call_guard<py::gil_scoped_release>());
}
