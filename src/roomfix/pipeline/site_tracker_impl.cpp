#include "roomfix/pipeline/site_tracker_impl.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "roomfix/base/steady_now.hpp"

namespace roomfix {
namespace {

const std::string range_source_name = "ranges";
const std::string sighting_source_name = "sightings";

/// The site with one more kind of target for the tracker: whatever is no robot.
Site with_unknown(Site site) {
    SiteRobot unknown;
    unknown.id = "unknown";
    unknown.shape = Cylinder{0.5, 1.7};
    unknown.size_sigma = 0.1;
    unknown.many = unknown.unknown = true;
    site.robots.push_back(unknown);
    return site;
}

}  // namespace

SiteTracker::Impl::Impl(const Site& site) : site_(site), joint_bodies_(site), receivers_(site), tracker_(with_unknown(site)) {}

Result<void> SiteTracker::Impl::add_camera(const SiteCamera& camera) {
    auto pipeline = CameraPipeline::create(site_, camera);
    if (!pipeline) return pipeline.error();
    if (!*pipeline) return {};  // it finds no robot
    cameras_.push_back(std::make_unique<Camera>());
    cameras_.back()->pipeline = std::move(*pipeline);
    cameras_.back()->state.id = camera.id;
    return {};
}

Result<void> SiteTracker::Impl::check_size(const CameraFrame& frame) {
    const CameraModel& model = camera(frame.camera).model;
    if (frame.image.grey.width == model.width && frame.image.grey.height == model.height) return {};
    const std::string message = fmt::format(
        "camera {}: the frame is {} x {} pixels, the site file says {} x {}: correct 'size' and 'intrinsics', "
        "or the camera's settings",
        camera(frame.camera).id, frame.image.grey.width, frame.image.grey.height, model.width, model.height);
    set_camera_state(frame.camera, "failed", message);
    return Error{message};
}

Result<void> SiteTracker::Impl::process(const std::vector<CameraFrame>& frames, WorkerPool& pool) {
    if (frames.empty()) return {};
    const double before = steady_now();
    auto result = process_round(frames, pool);
    times_.add(Stage::moment, steady_now() - before);
    return result;
}

Result<void> SiteTracker::Impl::process_round(const std::vector<CameraFrame>& frames, WorkerPool& pool) {
    Result<void> result;
    if (sensed_until_) sensed_until_(frames.front().time);
    std::vector<FrameHints> hints(frames.size());
    std::vector<std::optional<Look>> looks(frames.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
        if (auto fits = check_size(frames[i]); !fits) {
            if (result) result = fits;
            continue;
        }
        hints[i] = hints_for(*cameras_[frames[i].camera]->pipeline, frames[i].time);
        looks[i].emplace();
    }
    const auto fixed = std::count_if(frames.begin(), frames.end(), [this](const CameraFrame& f) { return is_fixed(f.camera); });
    bool outlines = false;  // of some camera are searched for
    for (std::size_t i = 0; i < frames.size(); ++i) {
        hints[i].bodies = fixed < 2;
        if (!is_fixed(frames[i].camera)) continue;
        cameras_[frames[i].camera]->turns.set(frames[i].time, outlines, hints[i].robots);
        outlines |= hints[i].robots.search_outlines;
    }
    pool.run(static_cast<int>(frames.size()), [&](int job) {
        const auto i = static_cast<std::size_t>(job);
        if (looks[i]) looks[i] = look(frames[i], hints[i]);
    });
    JointSighting joint;
    if (fixed >= 2) joint = look_together(frames, looks, hints);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        if (sensed_until_) sensed_until_(frames[i].time);
        if (!looks[i]) continue;
        report(frames[i], *looks[i]);
        delivery_.deliver();
    }
    for (const BodyPlace& thing : joint.things) joint.robots.push_back(observation_of(thing));
    if (!joint.robots.empty() || !joint.absent.empty()) {
        const std::lock_guard lock(mutex_);
        const double before = steady_now();
        tracker_.observe(frames.back().time, joint.source, joint.robots);
        for (const AbsenceObservation& absence : joint.absent) tracker_.observe(frames.back().time, joint.source, absence);
        times_.add(Stage::track, steady_now() - before);
        make_due(frames.back().time, joint.source, looks.back() ? looks.back()->parts : LatencyParts());
    }
    delivery_.deliver();
    return result;
}

/// What fixed cameras that looked at the same moment show together.
JointSighting SiteTracker::Impl::look_together(const std::vector<CameraFrame>& frames, std::vector<std::optional<Look>>& looks,
                                               const std::vector<FrameHints>& hints) {
    const std::lock_guard lock(joint_mutex_);
    const double before = steady_now();
    std::vector<FixedCamera*> cameras;
    std::vector<LumaView> pictures;
    Expectation expected;
    // In the order of the site file, whichever camera was the first: together they are one source.
    std::vector<std::size_t> order(frames.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return frames[a].camera < frames[b].camera; });
    for (const std::size_t i : order) {
        FixedCamera* camera = cameras_[frames[i].camera]->pipeline->fixed();
        if (looks[i] && looks[i]->frozen <= 0 && camera != nullptr && !camera->evidence().empty()) {
            cameras.push_back(camera);
            pictures.push_back(camera->picture());
            expected = hints[i].robots;
        }
    }
    if (cameras.empty()) return {};
    JointSighting together = joint_bodies_.find(cameras, pictures, expected);
    const double seconds = steady_now() - before;
    times_.add(Stage::fit, seconds);
    for (auto& look : looks) {
        if (look) look->parts.fitting = seconds;
    }
    return together;
}

SiteTracker::Impl::Look SiteTracker::Impl::look(const CameraFrame& frame, const FrameHints& hints) {
    const double before = steady_now();
    Look result;
    result.parts.waiting = delivery_.latency(frame.time).value_or(0);
    result.frozen = cameras_[frame.camera]->pipeline->look(frame.image, frame.time, hints);
    result.parts.looking = steady_now() - before;
    times_.add(Stage::look, result.parts.looking);
    return result;
}

FrameHints SiteTracker::Impl::hints_for(const CameraPipeline& camera, Nanoseconds time) const {
    const std::lock_guard lock(mutex_);
    FrameHints hints;
    hints.time = time;
    if (const FixedCamera* fixed = camera.fixed()) {
        hints.elsewhere = robots_elsewhere(fixed->view(), time);
        hints.robots.robots = tracker_.expected(time);
        hints.robots.nameless = tracker_.nameless(time);
        hints.robots.things = expected_things(time);
    }
    if (camera.robot() < 0) return hints;
    hints.ranges = receivers_.near(camera.robot(), time);
    hints.expected = tracker_.expected(camera.robot(), time);
    return hints;
}

/// Where things should be that are no robots. The mutex is held.
std::vector<PoseObservation> SiteTracker::Impl::expected_things(Nanoseconds time) const {
    std::vector<PoseObservation> expected;
    for (const Fix& fix : tracker_.fixes(time)) {
        if (fix.unknown && fix.status != FixStatus::none) expected.push_back({unknown_robot(), fix.pose, false, fix.covariance});
    }
    return expected;
}

/// What is no robot, as the tracker is told of it.
PoseObservation SiteTracker::Impl::observation_of(const BodyPlace& thing) const { return {unknown_robot(), thing.pose, false, thing.covariance}; }

/// Robots that are surely where a fixed camera does not see them, each with a flag: behind a wall, or outside the picture. The
/// mutex is held.
std::vector<char> SiteTracker::Impl::robots_elsewhere(const View& view, Nanoseconds time) const {
    constexpr double sure = 0.04;    // m^2, variance of the place
    constexpr double margin = 0.15;  // of the picture's size, around it
    std::vector<char> elsewhere(site_.robots.size(), 0);
    for (std::size_t r = 0; r < site_.robots.size(); ++r) {
        if (site_.robots[r].many) continue;
        const auto fix = tracker_.fix(static_cast<int>(r), time);
        if (!fix || fix->status != FixStatus::ok || fix->covariance.topLeftCorner<2, 2>().trace() > sure) continue;
        const Eigen::Vector3d middle(fix->pose.x, fix->pose.y, half_size(site_.robots[r].shape).z());
        const auto pixel = project_map_point(view, middle);
        const bool outside = !pixel || !view.model.contains(*pixel, -margin * view.model.width);
        elsewhere[r] = outside || wall_between(site_.walls, view.position().head<2>(), middle.head<2>());
    }
    // Which of several look-alikes it is that is elsewhere, nobody knows for sure: all of them, or none.
    std::vector<char> surely = elsewhere;
    for (std::size_t r = 0; r < site_.robots.size(); ++r) {
        for (std::size_t other = 0; other < site_.robots.size(); ++other) {
            if (!elsewhere[other] && hard_to_tell(site_.robots[r], site_.robots[other])) surely[r] = 0;
        }
    }
    return surely;
}

/// Tells the tracker what a frame showed, and passes its fixes on.
void SiteTracker::Impl::report(const CameraFrame& frame, const Look& look) {
    Camera& camera = *cameras_[frame.camera];
    const std::lock_guard lock(mutex_);
    CameraState& state = camera.state;
    if (look.frozen > 0) {
        state.status = "frozen";
        state.message = fmt::format("not used: the same picture for {:.1f} s; restart the camera", look.frozen);
        tell_status(camera);
        make_due(frame.time, camera.pipeline->id(), look.parts);
        return;
    }
    ++state.frames;
    state.status = "ok";
    state.busy = state.frames == 1 ? look.parts.looking : 0.9 * state.busy + 0.1 * look.parts.looking;
    const double now = steady_now();
    if (camera.last_wall > 0) {
        const double rate = 1 / std::max(now - camera.last_wall, 1e-4);
        state.rate = state.rate == 0 ? rate : 0.9 * state.rate + 0.1 * rate;
    }
    camera.last_wall = now;
    if (keeps_frames_) {
        auto shown = std::make_shared<ShownFrame>(camera.pipeline->shown(frame.image.grey));
        shown->time = frame.time;
        camera.shown = std::move(shown);
    }
    const double before = steady_now();
    Sighting sighting = camera.pipeline->sighting();
    set_time_error(sighting, frame.time_error);
    feed(tracker_, frame.time, camera.pipeline->id(), sighting);
    times_.add(Stage::track, steady_now() - before);
    state.message = sighting.reason;
    if (const FixedCamera* fixed = camera.pipeline->fixed()) {
        if (fixed->changed()) {
            state.status = "changed";
            state.message = "a large part of the picture differs from its background: was the camera moved, or the light switched?";
        }
        if (fixed->moved()) {
            state.status = "moved";
            state.message = fixed->how_moved();
        }
    }
    note_quarantine(*camera.pipeline, state);
    tell_status(camera);
    make_due(frame.time, camera.pipeline->id(), look.parts);
}

/// Tells the camera's state what the tracker does not believe of it. The mutex is held.
void SiteTracker::Impl::note_quarantine(const CameraPipeline& camera, CameraState& state) const {
    for (const Quarantine& q : tracker_.quarantines()) {
        if (q.source != camera.id()) continue;
        if (q.sees_others_right) {
            state.message = fmt::format("it sees {} {:.2f} m from where everything else puts it: something there looks like {}", q.robot, q.distance, q.robot);
            continue;
        }
        state.status = "quarantined";
        state.message =
            fmt::format("not used: it sees {} {:.2f} m from where everything else puts it; was the camera moved, or does something there look like {}?",
                        q.robot, q.distance, q.robot);
        return;
    }
}

void SiteTracker::Impl::process(const RangeBatch& batch) {
    line_problems_.note(batch.problems, steady_now());
    {
        const std::lock_guard lock(mutex_);
        for (const RangeDifferenceObservation& difference : batch.differences) {
            tracker_.observe(difference);
            make_due(difference.time, range_source_name);
        }
        for (const RangeObservation& range : batch.ranges) {
            receivers_.keep(range);
            tracker_.observe(range);
            make_due(range.time, range_source_name);
        }
    }
    delivery_.deliver();
}

void SiteTracker::Impl::process(const SightingBatch& batch) {
    line_problems_.note(batch.problems, steady_now());
    {
        const std::lock_guard lock(mutex_);
        for (const SightingObservation& sighting : batch.sightings) {
            tracker_.observe(sighting);
            make_due(sighting.time, sighting_source_name);
        }
    }
    delivery_.deliver();
}

void SiteTracker::Impl::process(const OdometryBatch& batch) {
    line_problems_.note(batch.problems, steady_now());
    {
        const std::lock_guard lock(mutex_);
        for (const OdometryObservation& pose : batch.poses) {
            tracker_.observe(pose);
            last_report_ = pose.time;
            if (pose.robot >= 0 && pose.robot < unknown_robot()) delivery_.add_odometry(pose);
            if (!wheels_give_fix(pose.robot, pose.time)) continue;
            const std::string& driven = site_.robots[static_cast<std::size_t>(pose.robot)].id;
            delivery_.make_due(pose.time, tracker_.fixes(pose.time), [&](const Fix& fix) { return fix.robot == driven; }, {});
        }
    }
    delivery_.deliver();
}

/// A robot that its own senses found has fixes at an even rate, however seldom it hears or sees something; so has every robot while nothing but wheels speaks:
/// all cameras are gone. The mutex is held.
bool SiteTracker::Impl::wheels_give_fix(int robot, Nanoseconds time) const {
    constexpr double interval = 0.1;  // s
    const Track* track = tracker_.track(robot);
    if (track == nullptr || time < track->time) return false;
    const bool wheels_alone = std::abs(to_seconds(time - last_word_)) > tracker_.models().settings.ok;
    if (track->searched == never && !wheels_alone) return false;
    const auto last = delivery_.last_given(site_.robots[static_cast<std::size_t>(robot)].id);
    return !last || to_seconds(time - *last) >= interval;
}

/// A source speaks for the robots that it sees or that hear by it, and for those that nothing sees or hears. The mutex is held.
void SiteTracker::Impl::make_due(Nanoseconds time, const std::string& source, const LatencyParts& parts) {
    last_word_ = std::max(time, last_report_);  // pictures may take their time
    const auto is_due = [&](const Fix& fix) {
        return fix.status != FixStatus::ok || std::find(fix.sources.begin(), fix.sources.end(), source) != fix.sources.end();
    };
    delivery_.make_due(time, tracker_.fixes(time), is_due, parts);
}

void SiteTracker::Impl::set_camera_state(std::size_t index, const std::string& status, const std::string& message) {
    const std::lock_guard lock(mutex_);
    CameraState& state = cameras_[index]->state;
    state.status = status;
    state.message = message;
    if (status == "failed") ++state.bad_frames;
    tell_status(*cameras_[index]);
}

/// Once for each change. The mutex is held.
void SiteTracker::Impl::tell_status(Camera& camera) {
    if (camera.told == camera.state.status) return;
    camera.told = camera.state.status;
    if (status_listener_) status_listener_(camera.state);
}

void SiteTracker::Impl::note_source(std::size_t index, const std::string& note) {
    const std::lock_guard lock(mutex_);
    cameras_[index]->state.note = note;
}

std::vector<CameraState> SiteTracker::Impl::camera_states() const {
    const std::lock_guard lock(mutex_);
    std::vector<CameraState> states;
    for (const auto& camera : cameras_) states.push_back(camera->state);
    return states;
}

void SiteTracker::Impl::count_dropped(std::size_t index, long came, long dropped) {
    const std::lock_guard lock(mutex_);
    CameraState& state = cameras_[index]->state;
    const bool now = dropped > state.dropped;
    state.dropped = dropped;
    if (!now || state.status != "ok") return;
    state.status = "slow";
    state.message = fmt::format("{} of {} frames were not looked at: this machine is too slow for them; set the camera to fewer frames or a smaller picture",
                                dropped, came);
}

SiteSnapshot SiteTracker::Impl::snapshot(Nanoseconds time) const {
    const std::lock_guard lock(mutex_);
    SiteSnapshot snapshot;
    for (const auto& camera : cameras_) {
        snapshot.cameras.push_back(camera->state);
        snapshot.frames.push_back(camera->shown);
    }
    for (std::size_t r = 0; r < site_.robots.size(); ++r) {
        for (const RangeObservation& range : receivers_.near(static_cast<int>(r), time)) snapshot.ranges.push_back(range);
    }
    return snapshot;
}

std::shared_ptr<const ShownFrame> SiteTracker::Impl::shown_frame(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(cameras_.begin(), cameras_.end(), [&](const auto& camera) { return camera->pipeline->id() == name; });
    return found == cameras_.end() ? nullptr : (*found)->shown;
}

std::vector<std::string> SiteTracker::Impl::robots_not_found() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> reasons;
    for (std::size_t r = 0; r < site_.robots.size(); ++r) {
        const std::string& id = site_.robots[r].id;
        if (site_.robots[r].many || delivery_.last_status(id) != FixStatus::none) continue;
        const std::string reason = tracker_.why_not_found(static_cast<int>(r));
        if (!reason.empty()) reasons.push_back(fmt::format("robot {}: {}", id, reason));
    }
    return reasons;
}

}  // namespace roomfix
