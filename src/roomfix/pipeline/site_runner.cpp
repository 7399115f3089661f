#include "roomfix/pipeline/site_runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <optional>
#include <thread>

#include "roomfix/connect/range_source.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/pipeline/input_doctor.hpp"
#include "roomfix/pipeline/recorded_frames.hpp"
#include "roomfix/pipeline/wall_clock.hpp"

namespace roomfix {
namespace {

constexpr double publish_interval = 0.06;  // s: a screen needs no more
const std::string range_source_name = "ranges";
const std::string sighting_source_name = "sightings";

/// Cameras that looked together, each by its own name, none twice.
std::vector<std::string> single_sources(const std::vector<std::string>& sources) {
    std::vector<std::string> single;
    for (const std::string& source : sources) {
        for (std::size_t begin = 0; begin <= source.size();) {
            const std::size_t end = std::min(source.find('+', begin), source.size());
            const std::string name = source.substr(begin, end - begin);
            if (std::find(single.begin(), single.end(), name) == single.end()) single.push_back(name);
            begin = end + 1;
        }
    }
    return single;
}

}  // namespace

/// The site with one more kind of target for the tracker: whatever is no robot.
static Site with_unknown(Site site) {
    SiteRobot unknown;
    unknown.id = "unknown";
    unknown.shape = Cylinder{0.5, 1.7};
    unknown.size_sigma = 0.1;
    unknown.many = unknown.unknown = true;
    site.robots.push_back(unknown);
    return site;
}

SiteRunner::SiteRunner(const Site& site) : site_(site), joint_bodies_(site), ears_(site), tracker_(with_unknown(site)) {}

Result<std::unique_ptr<SiteRunner>> SiteRunner::create(const Site& site) {
    std::unique_ptr<SiteRunner> runner(new SiteRunner(site));
    if (site.robots.empty()) return Error{"the site has no robot: add one under 'robots' with its shape and size"};
    for (const SiteCamera& camera : site.cameras) {
        auto post = CameraPost::create(site, camera);
        if (!post) return post.error();
        if (!*post) continue;
        auto station = std::make_unique<Station>();
        station->post = std::move(*post);
        station->state.id = camera.id;
        runner->stations_.push_back(std::move(station));
    }
    const auto senses = [](const SiteRobot& robot) { return !robot.receivers.empty() || robot.detector; };
    if (runner->stations_.empty() && std::none_of(site.robots.begin(), site.robots.end(), senses)) {
        return Error{"the site has nothing that finds robots: give a camera 'pose', 'floor_points' or 'mount', or a robot a 'receiver' or a 'detector'"};
    }
    return runner;
}

void SiteRunner::keep_for_smoothing() {
    smoothing_ = true;
    tracker_.keep_history();
}

std::vector<Unsettled> SiteRunner::write_smoothed(const SmootherSettings& settings, const std::function<void(double)>& progress) {
    const std::lock_guard lock(mutex_);
    const Smoothed smoothed = smooth(tracker_, kept_, settings, progress);
    output_.give(smoothed.fixes);
    kept_.clear();
    return smoothed.unsettled;
}

std::vector<SiteCalibration> SiteRunner::calibrate(const std::function<void(double)>& progress) const {
    const std::lock_guard lock(mutex_);
    return calibrated_cameras(tracker_.models(), camera_errors_of(tracker_, kept_, progress));
}

Result<void> SiteRunner::serve_page(const std::string& host, int port) {
    page_ = std::make_unique<WebServer>();
    page_->set_site(site_json());
    page_->set_picture_source([this](const std::string& camera) { return picture_of(camera); });
    auto started = page_->start(host, port);
    if (!started) page_.reset();
    return started;
}

void SiteRunner::set_background(std::size_t index, BackgroundModel background, ColourBackground colour) {
    if (is_fixed(index)) stations_[index]->post->set_background(std::move(background), std::move(colour));
}

void SiteRunner::set_source_state(std::size_t index, const std::string& status, const std::string& message) {
    const std::lock_guard lock(mutex_);
    SourceState& state = stations_[index]->state;
    state.status = status;
    state.message = message;
    if (status == "failed") ++state.bad_frames;
}

std::vector<SourceState> SiteRunner::source_states() const {
    const std::lock_guard lock(mutex_);
    std::vector<SourceState> states;
    for (const auto& station : stations_) states.push_back(station->state);
    return states;
}

void SiteRunner::measure_latency() { pace_ = Pace{wall_clock(), system_now(), 1}; }

/// Seconds of the clock from a time stamp to now.
std::optional<double> SiteRunner::latency(Nanoseconds time) const {
    if (!pace_) return std::nullopt;
    return wall_clock() - pace_->wall_of(time);
}

Result<void> SiteRunner::check_size(const CameraFrame& frame) {
    const CameraModel& model = camera(frame.camera).model;
    if (frame.image.grey.width == model.width && frame.image.grey.height == model.height) return {};
    const std::string message = fmt::format(
        "camera {}: the frame is {} x {} pixels, the site file says {} x {}: correct 'size' and 'intrinsics', "
        "or the camera's settings",
        camera(frame.camera).id, frame.image.grey.width, frame.image.grey.height, model.width, model.height);
    set_source_state(frame.camera, "failed", message);
    return Error{message};
}

Result<void> SiteRunner::feed(const CameraFrame& frame) {
    WorkerPool alone(1);
    return feed({frame}, alone);
}

Result<void> SiteRunner::feed(const std::vector<CameraFrame>& frames, WorkerPool& pool) {
    if (frames.empty()) return {};
    const double before = wall_clock();
    auto result = feed_round(frames, pool);
    times_.add(Stage::moment, wall_clock() - before);
    return result;
}

Result<void> SiteRunner::feed_round(const std::vector<CameraFrame>& frames, WorkerPool& pool) {
    Result<void> result;
    tell_until(frames.front().time);
    std::vector<FrameHints> hints(frames.size());
    std::vector<std::optional<Look>> looks(frames.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
        if (auto fits = check_size(frames[i]); !fits) {
            if (result) result = fits;
            continue;
        }
        hints[i] = hints_for(*stations_[frames[i].camera]->post, frames[i].time);
        looks[i].emplace();
    }
    const auto fixed = std::count_if(frames.begin(), frames.end(), [this](const CameraFrame& f) { return is_fixed(f.camera); });
    bool outlines = false;  // of some camera are searched for
    for (std::size_t i = 0; i < frames.size(); ++i) {
        hints[i].bodies = fixed < 2;
        if (!is_fixed(frames[i].camera)) continue;
        stations_[frames[i].camera]->turns.set(frames[i].time, outlines, hints[i].robots);
        outlines |= hints[i].robots.search_outlines;
    }
    pool.run(static_cast<int>(frames.size()), [&](int job) {
        const auto i = static_cast<std::size_t>(job);
        if (looks[i]) looks[i] = look(frames[i], hints[i]);
    });
    JointSighting joint;
    if (fixed >= 2) joint = look_together(frames, looks, hints);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        tell_until(frames[i].time);
        if (looks[i]) report(frames[i], *looks[i]);
    }
    const std::lock_guard lock(mutex_);
    for (const BodyPlace& thing : joint.things) joint.robots.push_back(observation_of(thing));
    if (!joint.robots.empty()) {
        const double before = wall_clock();
        tracker_.see(frames.back().time, joint.source, joint.robots);
        times_.add(Stage::track, wall_clock() - before);
        pass_on(frames.back().time, joint.source, looks.back() ? looks.back()->parts : LatencyParts());
    }
    return result;
}

/// What fixed cameras that looked at the same moment show together.
JointSighting SiteRunner::look_together(const std::vector<CameraFrame>& frames, std::vector<std::optional<Look>>& looks, const std::vector<FrameHints>& hints) {
    const std::lock_guard lock(joint_mutex_);
    const double before = wall_clock();
    std::vector<CameraPost*> posts;
    std::vector<LumaView> pictures;
    Expectation expected;
    // In the order of the site file, whichever camera was the first: together they are one source.
    std::vector<std::size_t> order(frames.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return frames[a].camera < frames[b].camera; });
    for (const std::size_t i : order) {
        CameraPost* post = stations_[frames[i].camera]->post.get();
        if (looks[i] && looks[i]->frozen <= 0 && post->is_fixed() && !post->evidence().empty()) {
            posts.push_back(post);
            pictures.push_back(frames[i].image.grey);
            expected = hints[i].robots;
        }
    }
    if (posts.empty()) return {};
    JointSighting together = joint_bodies_.find(posts, pictures, expected);
    const double seconds = wall_clock() - before;
    times_.add(Stage::fit, seconds);
    for (auto& look : looks) {
        if (look) look->parts.fitting = seconds;
    }
    return together;
}

SiteRunner::Look SiteRunner::look(const CameraFrame& frame, const FrameHints& hints) {
    const double before = wall_clock();
    Look result;
    result.parts.waiting = latency(frame.time).value_or(0);
    result.frozen = stations_[frame.camera]->post->look(frame.image, frame.time, hints);
    result.parts.looking = wall_clock() - before;
    times_.add(Stage::look, result.parts.looking);
    return result;
}

FrameHints SiteRunner::hints_for(const CameraPost& post, Nanoseconds time) const {
    const std::lock_guard lock(mutex_);
    FrameHints hints;
    if (post.is_fixed()) {
        hints.elsewhere = robots_elsewhere(post, time);
        hints.robots.robots = tracker_.expected(time);
        hints.robots.things = expected_things(time);
    }
    if (post.robot() < 0) return hints;
    hints.ranges = ears_.near(post.robot(), time);
    hints.expected = tracker_.expected(post.robot(), time);
    return hints;
}

/// Where things should be that are no robots. The mutex is held.
std::vector<PoseObservation> SiteRunner::expected_things(Nanoseconds time) const {
    std::vector<PoseObservation> expected;
    for (const Fix& fix : tracker_.fixes(time)) {
        if (fix.unknown && fix.status != FixStatus::none) expected.push_back({unknown_robot(), fix.pose, false, fix.covariance});
    }
    return expected;
}

/// What is no robot, as the tracker is told of it.
PoseObservation SiteRunner::observation_of(const BodyPlace& thing) const { return {unknown_robot(), thing.pose, false, thing.covariance}; }

/// Robots that are surely where a fixed camera does not see them, each with a flag: behind a wall, or outside the picture. The
/// mutex is held.
std::vector<char> SiteRunner::robots_elsewhere(const CameraPost& post, Nanoseconds time) const {
    constexpr double sure = 0.04;    // m^2, variance of the place
    constexpr double margin = 0.15;  // of the picture's size, around it
    std::vector<char> elsewhere(site_.robots.size(), 0);
    const View& view = post.view();
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
void SiteRunner::report(const CameraFrame& frame, const Look& look) {
    Station& station = *stations_[frame.camera];
    const std::lock_guard lock(mutex_);
    SourceState& state = station.state;
    if (look.frozen > 0) {
        state.status = "frozen";
        state.message = fmt::format("not used: the same picture for {:.1f} s; restart the camera", look.frozen);
        pass_on(frame.time, station.post->id(), look.parts);
        return;
    }
    ++state.frames;
    state.status = "ok";
    state.busy = state.frames == 1 ? look.parts.looking : 0.9 * state.busy + 0.1 * look.parts.looking;
    const double now = wall_clock();
    if (station.last_wall > 0) {
        const double rate = 1 / std::max(now - station.last_wall, 1e-4);
        state.rate = state.rate == 0 ? rate : 0.9 * state.rate + 0.1 * rate;
    }
    station.last_wall = now;
    if (page_) station.post->show(frame.image.grey);
    const double before = wall_clock();
    station.post->tell(tracker_, frame.time);
    times_.add(Stage::track, wall_clock() - before);
    state.message = station.post->reason();
    if (station.post->changed()) {
        state.status = "changed";
        state.message = "a large part of the picture differs from its background: was the camera moved, or the light switched?";
    }
    note_quarantine(*station.post, state);
    pass_on(frame.time, station.post->id(), look.parts);
}

/// Tells the camera's state what the tracker does not believe of it. The mutex is held.
void SiteRunner::note_quarantine(const CameraPost& post, SourceState& state) const {
    for (const Quarantine& q : tracker_.quarantines()) {
        if (q.source != post.id()) continue;
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

void SiteRunner::add_problems(const std::vector<std::string>& problems) {
    for (const std::string& problem : problems) {
        if (line_problems_.size() < 20) line_problems_.push_back(problem);
    }
}

void SiteRunner::hear(const RangeBatch& batch) {
    const std::lock_guard lock(mutex_);
    add_problems(batch.problems);
    for (const RangeDifferenceObservation& difference : batch.differences) {
        tracker_.hear(difference);
        pass_on(difference.time, range_source_name);
    }
    for (const RangeObservation& range : batch.ranges) {
        ears_.keep(range);
        tracker_.hear(range);
        pass_on(range.time, range_source_name);
    }
}

void SiteRunner::detect(const SightingBatch& batch) {
    const std::lock_guard lock(mutex_);
    add_problems(batch.problems);
    for (const SightingObservation& sighting : batch.sightings) {
        tracker_.detect(sighting);
        pass_on(sighting.time, sighting_source_name);
    }
}

void SiteRunner::drive(const OdometryBatch& batch) {
    const std::lock_guard lock(mutex_);
    add_problems(batch.problems);
    for (const OdometryObservation& pose : batch.poses) {
        tracker_.drive(pose);
        if (!wheels_give_fix(pose.robot, pose.time)) continue;
        const std::string& driven = site_.robots[static_cast<std::size_t>(pose.robot)].id;
        pass_on(pose.time, [&](const Fix& fix) { return fix.robot == driven; }, {});
    }
}

/// A robot that its own senses found has fixes at an even rate, however seldom it hears or sees something. The mutex is held.
bool SiteRunner::wheels_give_fix(int robot, Nanoseconds time) const {
    constexpr double interval = 0.1;  // s
    const Track* track = tracker_.track(robot);
    if (track == nullptr || track->searched == never || time < track->time) return false;
    const auto last = last_given_.find(site_.robots[static_cast<std::size_t>(robot)].id);
    return last == last_given_.end() || to_seconds(time - last->second) >= interval;
}

std::vector<std::string> SiteRunner::line_problems() const {
    const std::lock_guard lock(mutex_);
    return line_problems_;
}

std::vector<std::string> SiteRunner::robots_not_found() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> reasons;
    for (std::size_t r = 0; r < site_.robots.size(); ++r) {
        const std::string& id = site_.robots[r].id;
        const auto given = last_status_.find(id);
        if (site_.robots[r].many || (given != last_status_.end() && given->second != FixStatus::none)) continue;
        const std::string reason = tracker_.why_not_found(static_cast<int>(r));
        if (!reason.empty()) reasons.push_back(fmt::format("robot {}: {}", id, reason));
    }
    return reasons;
}

std::vector<std::string> SiteRunner::suspicious_inputs() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> told;
    for (std::size_t r = 0; r < site_.robots.size(); ++r) {
        const int robot = static_cast<int>(r);
        if (site_.robots[r].many) continue;
        for (const std::string& suspicion : suspicions(tracker_, robot, recorded_.of(robot))) told.push_back(suspicion);
    }
    return told;
}

TrackerCounts SiteRunner::tracker_counts() const {
    const std::lock_guard lock(mutex_);
    return tracker_.counts();
}

/// Recorded ranges and odometry up to a time, as they would have come.
void SiteRunner::tell_until(Nanoseconds time) {
    SenseListener listener;
    listener.goes_on = [this](Nanoseconds next) {
        const std::lock_guard lock(mutex_);
        tracker_.go_on(next);
    };
    listener.hears = [this](const RangeBatch& batch) { hear(batch); };
    listener.drives = [this](const OdometryBatch& batch) { drive(batch); };
    listener.detects = [this](const SightingBatch& batch) { detect(batch); };
    recorded_.tell_until(time, listener);
}

/// A listener on a serial line, in a thread of its own; a device that vanishes is opened again when it comes back.
void SiteRunner::listen(const std::string& device, int robot, int receiver, const std::atomic<bool>& stop) {
    RangeReader reader(site_, robot, receiver);
    std::string bytes;
    while (!stop) {
        auto line = SerialLine::open(device);
        if (!line) {
            RangeBatch problem;
            problem.problems.push_back(line.error().message);
            hear(problem);
            for (int i = 0; i < 20 && !stop; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
            continue;
        }
        while (!stop && line->read(0.2, bytes)) {
            if (bytes.empty()) continue;
            RangeBatch batch;
            reader.feed(bytes, system_now(), batch);
            bytes.clear();
            hear(batch);
        }
    }
}

/// A source speaks for the robots that it sees or that hear by it, and for those that nothing sees or hears. The mutex is held.
void SiteRunner::pass_on(Nanoseconds time, const std::string& source, const LatencyParts& parts) {
    const auto is_due = [&](const Fix& fix) {
        return fix.status != FixStatus::ok || std::find(fix.sources.begin(), fix.sources.end(), source) != fix.sources.end();
    };
    pass_on(time, is_due, parts);
}

/// Gives the fixes of a time that are due to the file and, not too often, to the page. The mutex is held.
void SiteRunner::pass_on(Nanoseconds time, const std::function<bool(const Fix&)>& is_due, const LatencyParts& parts) {
    const double before = wall_clock();
    std::vector<Fix> fixes = tracker_.fixes(time);
    std::vector<Fix> given;
    for (Fix& fix : fixes) {
        FixStatus& last = last_status_.try_emplace(fix.robot, FixStatus::none).first->second;
        const bool said = fix.status == FixStatus::none && last == FixStatus::none;
        last = fix.status;
        if (said) continue;
        if (!is_due(fix)) continue;
        Nanoseconds& last_time = last_given_.try_emplace(fix.robot, never).first->second;
        if (fix.status != FixStatus::ok && last_time == time) continue;  // another source of the same moment has said it
        last_time = time;
        fix.latency = latency(time);
        if (fix.latency && parts.looking > 0) {
            fix.latency_parts = parts;
            fix.latency_parts->tracking = *fix.latency - parts.waiting - parts.looking - parts.fitting;
        }
        if (fix.latency) times_.add(Stage::latency, *fix.latency);
        fix.sources = single_sources(fix.sources);
        given.push_back(fix);
    }
    if (smoothing_) {
        kept_.insert(kept_.end(), given.begin(), given.end());
    } else {
        output_.give(given);
    }
    const double now = wall_clock();
    if (page_ && now - last_published_ > publish_interval) {
        last_published_ = now;
        page_->publish(state_json(time, fixes));
    }
    times_.add(Stage::publish, wall_clock() - before);
}

Result<void> SiteRunner::run_sources(const RunSettings& settings, const std::atomic<bool>& stop, const std::function<void(double)>& progress) {
    std::vector<std::unique_ptr<FrameSource>> sources;
    for (std::size_t i = 0; i < cameras(); ++i) {
        auto source = open_source(resolved_path(site_, camera(i).source));
        if (!source) return Error{fmt::format("camera {}: {}", camera(i).id, source.error().message)};
        sources.push_back(std::move(*source));
    }
    return run_sources(std::move(sources), settings, stop, progress);
}

Result<void> SiteRunner::run_sources(std::vector<std::unique_ptr<FrameSource>> sources, const RunSettings& settings, const std::atomic<bool>& stop,
                                     const std::function<void(double)>& progress) {
    auto recorded = RecordedSenses::load(site_);
    if (!recorded) return recorded.error();
    recorded_ = std::move(*recorded);
    for (std::size_t r = 0; r < site_.robots.size(); ++r) {
        const int robot = static_cast<int>(r);
        const std::string wrong = wrong_units(recorded_.of(robot).odometry, site_.robots[r]);
        if (!wrong.empty()) recorded_.drop_odometry(robot, wrong);
    }
    add_problems(recorded_.problems());
    std::vector<std::thread> threads;
    for (std::size_t r = 0; r < site_.robots.size(); ++r) {
        for (std::size_t k = 0; k < site_.robots[r].receivers.size(); ++k) {
            const std::string& source = site_.robots[r].receivers[k].source;
            if (!is_live_range_source(source)) continue;
            threads.emplace_back([this, source, robot = static_cast<int>(r), receiver = static_cast<int>(k), &stop] { listen(source, robot, receiver, stop); });
        }
    }
    const bool live = std::any_of(sources.begin(), sources.end(), [](const auto& source) { return source->live(); });
    if (live && settings.on_time) measure_latency();
    std::vector<LiveSource> live_sources;
    for (std::size_t i = 0; i < sources.size(); ++i) {
        if (sources[i]->live()) live_sources.push_back({i, sources[i].get()});
    }
    if (live) threads.emplace_back([&] { run_live(live_sources, settings.threads, stop); });
    auto done = run_recorded(sources, settings, stop, progress);
    for (auto& thread : threads) thread.join();
    return done;
}

/// Cameras that see the same moment are looked at together, as in a recording.
void SiteRunner::run_live(const std::vector<LiveSource>& sources, int threads, const std::atomic<bool>& stop) {
    LiveFrames frames(
        sources, stop, [this](std::size_t i, const std::string& message) { set_source_state(i, "failed", message); },
        [this](std::size_t i) { set_source_state(i, "ended", "the camera gives no more frames"); });
    WorkerPool pool(std::max(threads, 1));
    for (auto round = frames.next_round(); !round.empty(); round = frames.next_round()) {
        std::vector<CameraFrame> together;
        for (std::size_t i = 0; i < round.size(); ++i) {
            const SourceFrame& frame = round[i].frame;
            together.push_back({round[i].camera, {frame.image, &frame.colour}, frame.time});
            const bool last = i + 1 == round.size() || round[i + 1].frame.time - together.front().time > round_span;
            if (!last) continue;
            (void)feed(together, pool);
            together.clear();
        }
        for (const LiveFrame& frame : round) count_dropped(frame.camera, frame.count);
    }
}

/// Says so where this machine is too slow for a camera.
void SiteRunner::count_dropped(std::size_t index, const FrameCount& count) {
    const std::lock_guard lock(mutex_);
    SourceState& state = stations_[index]->state;
    const bool now = count.dropped > state.dropped;
    state.dropped = count.dropped;
    if (!now || state.status != "ok") return;
    state.status = "slow";
    state.message = fmt::format("{} of {} frames were not looked at: this machine is too slow for them; set the camera to fewer frames or a smaller picture",
                                count.dropped, count.came);
}

std::vector<std::uint8_t> SiteRunner::picture_of(const std::string& camera) {
    LumaImage picture;
    {
        const std::lock_guard lock(mutex_);
        for (const auto& station : stations_) {
            if (station->post->id() == camera) picture = station->post->shown_frame();
        }
    }
    return picture.empty() ? std::vector<std::uint8_t>() : encode_jpeg(picture, 80);
}

}  // namespace roomfix
