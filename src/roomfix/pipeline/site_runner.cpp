#include "roomfix/pipeline/site_runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <limits>
#include <optional>
#include <thread>

#include "roomfix/connect/fix_json.hpp"
#include "roomfix/connect/range_source.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/overhead/robot_tag.hpp"

namespace roomfix {
namespace {

constexpr double publish_interval = 0.06;  // s: a screen needs no more
const std::string range_source_name = "ranges";
const std::string range_places_name = "places by ranges";

double wall_clock() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace

SiteRunner::SiteRunner(const Site& site) : site_(site), tracker_(site) {}

Result<std::unique_ptr<SiteRunner>> SiteRunner::create(const Site& site) {
    std::unique_ptr<SiteRunner> runner(new SiteRunner(site));
    if (site.robots.empty()) return Error{"the site has no robot: add one under 'robots' with its shape and size"};
    const bool robots_wear_tags = std::any_of(site.robots.begin(), site.robots.end(), [](const SiteRobot& r) { return r.tag.has_value(); });
    for (const SiteCamera& camera : site.cameras) {
        auto post = std::make_unique<Post>();
        post->camera = camera;
        post->state.id = camera.id;
        const bool of_height = std::holds_alternative<KnownHeight>(camera.placement);
        if (of_height && (site.corners.empty() || std::get<KnownHeight>(camera.placement).robot.empty())) continue;  // finds no robot
        if (looks_for_corners(site, camera)) {
            auto corners = CornerCamera::for_camera(site, camera);
            if (!corners) return corners.error();
            post->corners = std::move(*corners);
        } else if (std::holds_alternative<Mount>(camera.placement)) {
            auto locator = OnboardLocator::for_camera(site, camera);
            if (!locator) return locator.error();
            post->locator = std::move(*locator);
        } else {
            const auto view = fixed_view(camera);
            if (!view) return view.error();
            post->observer = std::make_unique<OverheadObserver>(*view, site.robots);
            if (robots_wear_tags) post->tags.emplace();
        }
        runner->posts_.push_back(std::move(post));
    }
    auto ears = RangeEars::create(site);
    if (!ears) return ears.error();
    runner->ears_ = std::move(*ears);
    if (runner->posts_.empty() && runner->ears_.empty()) {
        return Error{"the site has nothing that finds robots: give a camera 'pose', 'floor_points' or 'mount', or a robot a 'receiver'"};
    }
    return runner;
}

Result<void> SiteRunner::write_fixes_to(const std::string& file) {
    if (file == "-") {
        fixes_to_stdout_ = true;
        return {};
    }
    fixes_file_.open(file, std::ios::binary);
    if (!fixes_file_) return Error{fmt::format("{}: cannot be written: check that the folder exists", file)};
    return {};
}

Result<void> SiteRunner::serve_page(const std::string& host, int port) {
    page_ = std::make_unique<WebServer>();
    page_->set_site(site_json());
    page_->set_picture_source([this](const std::string& camera) { return picture_of(camera); });
    auto started = page_->start(host, port);
    if (!started) page_.reset();
    return started;
}

void SiteRunner::set_background(std::size_t index, BackgroundModel background) {
    if (is_fixed(index)) posts_[index]->observer->set_background(std::move(background));
}

void SiteRunner::set_source_state(std::size_t index, const std::string& status, const std::string& message) {
    const std::lock_guard lock(mutex_);
    posts_[index]->state.status = status;
    posts_[index]->state.message = message;
    if (status == "failed") ++posts_[index]->state.bad_frames;
}

std::vector<SourceState> SiteRunner::source_states() const {
    const std::lock_guard lock(mutex_);
    std::vector<SourceState> states;
    for (const auto& post : posts_) states.push_back(post->state);
    return states;
}

Result<void> SiteRunner::feed(std::size_t index, LumaView frame, Nanoseconds time) {
    Post& post = *posts_[index];
    if (frame.width != post.camera.model.width || frame.height != post.camera.model.height) {
        const std::string message = fmt::format(
            "camera {}: the frame is {} x {} pixels, the site file says {} x {}: correct 'size' and 'intrinsics', "
            "or the camera's settings",
            post.camera.id, frame.width, frame.height, post.camera.model.width, post.camera.model.height);
        set_source_state(index, "failed", message);
        return Error{message};
    }
    const double before = wall_clock();
    const double frozen = post.frozen.seconds(frame, time);
    if (frozen > frozen_after) {
        set_source_state(index, "frozen", fmt::format("not used: the same picture for {:.1f} s; restart the camera", frozen));
        const std::lock_guard lock(mutex_);
        pass_on(time, post.camera.id);
        return {};
    }
    if (post.observer) watch(post, frame, time);
    if (post.corners) look_for_corner(post, frame, time);
    if (post.locator) look_up(post, frame, time);
    const double after = wall_clock();

    const std::lock_guard lock(mutex_);
    SourceState& state = post.state;
    ++state.frames;
    state.status = "ok";
    state.busy = state.frames == 1 ? after - before : 0.9 * state.busy + 0.1 * (after - before);
    if (post.last_wall > 0) {
        const double rate = 1 / std::max(after - post.last_wall, 1e-4);
        state.rate = state.rate == 0 ? rate : 0.9 * state.rate + 0.1 * rate;
    }
    post.last_wall = after;
    if (page_) {
        post.last = copy_of(frame);
        post.shown = post.result.observations;
        post.shown_onboard = post.onboard;
        post.shown_corner = post.corner;
    }
    tell_tracker(post, time);
    const auto quarantine = quarantine_of(post);
    if (quarantine) state.status = "quarantined";
    state.message = quarantine ? *quarantine : reason_of(post);
    pass_on(time, post.camera.id);
    return {};
}

/// Robots that are surely where a fixed camera does not see them, each with a flag: behind a wall, or outside the picture.
std::vector<char> SiteRunner::robots_elsewhere(const Post& post, Nanoseconds time) const {
    constexpr double sure = 0.04;    // m^2, variance of the place
    constexpr double margin = 0.15;  // of the picture's size, around it
    std::vector<char> elsewhere(site_.robots.size(), 0);
    const View& view = post.observer->view();
    const std::lock_guard lock(mutex_);
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
            if (!elsewhere[other] && look_alike(site_.robots[r], site_.robots[other])) surely[r] = 0;
        }
    }
    return surely;
}

/// What a fixed camera sees: outlines, and the tags of robots that wear one. A tag says more than an outline.
void SiteRunner::watch(Post& post, LumaView frame, Nanoseconds time) {
    post.observer->set_elsewhere(robots_elsewhere(post, time));
    post.observer->observe(frame, post.result);
    post.poses = poses_of(post.result.observations);
    if (!post.tags) return;
    for (const TaggedRobot& tagged : find_tagged_robots(post.observer->view(), site_.robots, *post.tags, frame)) {
        std::erase_if(post.poses, [&](const PoseObservation& o) { return o.robot == tagged.robot; });
        post.poses.push_back({tagged.robot, tagged.fit.pose, true, tagged.fit.covariance, 1, tagged.fit.by_camera, true});
    }
}

/// What a camera on a robot sees, with the ranges of that moment to tell like landmarks apart.
void SiteRunner::look_up(Post& post, LumaView frame, Nanoseconds time) {
    const int robot = post.locator->robot();
    std::vector<RangeObservation> ranges;
    std::optional<PoseObservation> expected;
    {
        const std::lock_guard lock(mutex_);
        ranges = ears_.near(robot, time);
        expected = tracker_.expected(robot, time);
    }
    post.locator->locate(&frame, ranges, expected, -1, post.onboard);
}

/// What a camera sees that looks for corners.
void SiteRunner::look_for_corner(Post& post, LumaView frame, Nanoseconds time) {
    const int robot = post.corners->robot();
    CameraHints hints;
    std::vector<RangeObservation> ranges;
    {
        const std::lock_guard lock(mutex_);
        ranges = ears_.near(robot, time);
        const auto expected = tracker_.expected(robot, time);
        if (expected && expected->yaw_known) hints.prediction = CameraHints::Prediction{expected->pose, expected->covariance};
    }
    hints.ranges = ranges;
    post.corners->look(frame, hints, post.corner);
}

/// The last frame's observations. The mutex is held.
void SiteRunner::tell_tracker(const Post& post, Nanoseconds time) {
    if (post.observer) tracker_.see(time, post.camera.id, post.poses);
    if (post.locator && !post.onboard.located.places.empty()) {
        tracker_.see(time, post.camera.id, LandmarkSighting{post.locator->robot(), post.onboard.seen.landmarks, proposals_of(post.onboard.located.places)});
    }
    if (!post.corners || post.corner.located.places.empty()) return;
    const auto& places = post.corner.located.places;
    if (std::holds_alternative<Mount>(post.camera.placement)) {
        CornerSighting sighting{post.corners->robot(), post.corner.seen.corners, {}};
        for (const CameraPlace& p : places) sighting.proposals.push_back({p.pose, p.covariance, p.yaw_known, p.weight});
        tracker_.see(time, post.camera.id, sighting);
    } else if (places[0].weight >= likely) {
        // A camera of which only the height is known stands where the robot stands.
        const PoseObservation pose{post.corners->robot(), places[0].pose, places[0].yaw_known, places[0].covariance};
        tracker_.see(time, post.camera.id, {&pose, 1});
    }
}

/// Why the camera is not believed at present, if it is not. The mutex is held.
std::optional<std::string> SiteRunner::quarantine_of(const Post& post) const {
    for (const Quarantine& q : tracker_.quarantines()) {
        if (q.source != post.camera.id) continue;
        return fmt::format("not used: it sees {} {:.2f} m from where everything else puts it; was the camera moved?", q.robot, q.distance);
    }
    return std::nullopt;
}

const std::string& SiteRunner::reason_of(const Post& post) const {
    if (post.observer) return post.result.reason;
    return post.corners ? post.corner.located.reason : post.onboard.located.reason;
}

void SiteRunner::add_problems(const std::vector<std::string>& problems) {
    for (const std::string& problem : problems) {
        if (line_problems_.size() < 20) line_problems_.push_back(problem);
    }
}

void SiteRunner::hear(const RangeBatch& batch) {
    const std::lock_guard lock(mutex_);
    add_problems(batch.problems);
    for (const RangeDifferenceObservation& difference : batch.differences) tracker_.hear(difference);
    for (const RangeObservation& range : batch.ranges) {
        if (!ears_.hears(range.robot)) continue;
        ears_.keep(range);
        // A robot that is lost is found by its ranges alone; one that is tracked only takes them in.
        if (const auto places = ears_.places(range.robot, range.time)) tracker_.propose(range.time, range_places_name, *places);
        tracker_.hear(range);
        pass_on(range.time, range_source_name);
    }
}

void SiteRunner::drive(const OdometryBatch& batch) {
    const std::lock_guard lock(mutex_);
    add_problems(batch.problems);
    for (const OdometryObservation& pose : batch.poses) tracker_.drive(pose);
}

std::vector<std::string> SiteRunner::line_problems() const {
    const std::lock_guard lock(mutex_);
    return line_problems_;
}

TrackerCounts SiteRunner::tracker_counts() const {
    const std::lock_guard lock(mutex_);
    return tracker_.counts();
}

/// Recorded ranges and odometry of all robots. One file may hold those of several: it is read once.
Result<void> SiteRunner::load_recorded() {
    recorded_ranges_.clear();
    recorded_odometry_ = {};
    next_range_ = next_odometry_ = 0;
    std::vector<std::string> read;
    const auto is_new = [&](const std::string& file) {
        if (file.empty() || std::find(read.begin(), read.end(), file) != read.end()) return false;
        read.push_back(file);
        return true;
    };
    for (std::size_t r = 0; r < site_.robots.size(); ++r) {
        const SiteRobot& robot = site_.robots[r];
        if (robot.receiver && !is_live_range_source(robot.receiver->source) && is_new(robot.receiver->source)) {
            const auto batch = load_ranges(resolved_path(site_, robot.receiver->source), site_, static_cast<int>(r));
            if (!batch) return batch.error();
            recorded_ranges_.ranges.insert(recorded_ranges_.ranges.end(), batch->ranges.begin(), batch->ranges.end());
            recorded_ranges_.differences.insert(recorded_ranges_.differences.end(), batch->differences.begin(), batch->differences.end());
            add_problems(batch->problems);
        }
        if (robot.odometry && is_new(robot.odometry->source)) {
            const auto batch = load_odometry(resolved_path(site_, robot.odometry->source), site_, static_cast<int>(r));
            if (!batch) return batch.error();
            recorded_odometry_.poses.insert(recorded_odometry_.poses.end(), batch->poses.begin(), batch->poses.end());
            add_problems(batch->problems);
        }
    }
    const auto earlier = [](const auto& a, const auto& b) { return a.time < b.time; };
    std::stable_sort(recorded_ranges_.ranges.begin(), recorded_ranges_.ranges.end(), earlier);
    std::stable_sort(recorded_ranges_.differences.begin(), recorded_ranges_.differences.end(), earlier);
    std::stable_sort(recorded_odometry_.poses.begin(), recorded_odometry_.poses.end(), earlier);
    return {};
}

/// Recorded ranges and odometry up to a time, as they would have come.
void SiteRunner::tell_until(Nanoseconds time) {
    auto& differences = recorded_ranges_.differences;
    while (true) {
        const auto& ranges = recorded_ranges_.ranges;
        const auto& poses = recorded_odometry_.poses;
        constexpr Nanoseconds ended = std::numeric_limits<Nanoseconds>::max();
        const Nanoseconds range_time = next_range_ < ranges.size() ? ranges[next_range_].time : ended;
        const Nanoseconds pose_time = next_odometry_ < poses.size() ? poses[next_odometry_].time : ended;
        const Nanoseconds next = std::min(range_time, pose_time);
        if (next > time || next == ended) break;
        if (pose_time <= range_time) {
            drive({{poses[next_odometry_++]}, {}});
        } else {
            RangeBatch one;
            one.ranges.push_back(ranges[next_range_++]);
            hear(one);
        }
    }
    RangeBatch now;
    while (next_difference_ < differences.size() && differences[next_difference_].time <= time) now.differences.push_back(differences[next_difference_++]);
    if (!now.differences.empty()) hear(now);
}

/// A listener on a serial line, in a thread of its own; a device that vanishes is opened again when it comes back.
void SiteRunner::listen(const std::string& device, int robot, const std::atomic<bool>& stop) {
    RangeReader reader(site_, robot);
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
            reader.feed(bytes, std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count(), batch);
            bytes.clear();
            hear(batch);
        }
    }
}

/// Gives the fixes of a time to the file and, not too often, to the page. The mutex is held.
void SiteRunner::pass_on(Nanoseconds time, const std::string& camera) {
    const std::vector<Fix> fixes = tracker_.fixes(time);
    for (const Fix& fix : fixes) {
        FixStatus& last = last_status_.try_emplace(fix.robot, FixStatus::none).first->second;
        const bool said = fix.status == FixStatus::none && last == FixStatus::none;
        last = fix.status;
        if (said) continue;
        // A frame speaks for the robots that its own camera sees; the others' cameras speak for theirs.
        const bool seen_here = std::find(fix.sources.begin(), fix.sources.end(), camera) != fix.sources.end();
        if (!seen_here && fix.status == FixStatus::ok) continue;
        ++fixes_given_;
        if (fixes_to_stdout_) std::cout << fix_line(fix) << '\n';
        if (fixes_file_.is_open()) fixes_file_ << fix_line(fix) << '\n';
    }
    if (fixes_to_stdout_) std::cout.flush();
    if (fixes_file_.is_open()) fixes_file_.flush();
    const double now = wall_clock();
    if (page_ && now - last_published_ > publish_interval) {
        last_published_ = now;
        page_->publish(state_json(time, fixes));
    }
}

Result<void> SiteRunner::run_sources(double speed, const std::atomic<bool>& stop, const std::function<void(double)>& progress) {
    std::vector<std::unique_ptr<FrameSource>> sources(posts_.size());
    for (std::size_t i = 0; i < posts_.size(); ++i) {
        auto source = open_source(resolved_path(site_, posts_[i]->camera.source));
        if (!source) return Error{fmt::format("camera {}: {}", posts_[i]->camera.id, source.error().message)};
        sources[i] = std::move(*source);
    }
    if (auto loaded = load_recorded(); !loaded) return loaded;
    std::vector<std::thread> threads;
    for (std::size_t r = 0; r < site_.robots.size(); ++r) {
        const auto& receiver = site_.robots[r].receiver;
        if (receiver && is_live_range_source(receiver->source)) {
            threads.emplace_back([this, device = receiver->source, robot = static_cast<int>(r), &stop] { listen(device, robot, stop); });
        }
    }
    for (std::size_t i = 0; i < sources.size(); ++i) {
        if (sources[i]->live()) threads.emplace_back([this, i, &sources, &stop] { run_live(i, *sources[i], stop); });
    }
    const auto done = run_recorded(sources, speed, stop, progress);
    for (auto& thread : threads) thread.join();
    return done;
}

void SiteRunner::run_live(std::size_t index, FrameSource& source, const std::atomic<bool>& stop) {
    SourceFrame frame;
    while (!stop) {
        const auto more = source.next(frame);
        if (!more) {
            set_source_state(index, "failed", more.error().message);
            std::this_thread::sleep_for(std::chrono::milliseconds(200));
            continue;
        }
        if (!*more) break;
        (void)feed(index, frame.image, frame.time);
    }
    set_source_state(index, "ended", "the camera gives no more frames");
}

Result<void> SiteRunner::run_recorded(std::vector<std::unique_ptr<FrameSource>>& sources, double speed, const std::atomic<bool>& stop,
                                      const std::function<void(double)>& progress) {
    std::vector<std::optional<SourceFrame>> waiting(sources.size());
    double total = 0;
    const auto fetch = [&](std::size_t i) {
        waiting[i].reset();
        while (!stop) {
            SourceFrame frame;
            const auto more = sources[i]->next(frame);
            if (!more) {
                set_source_state(i, "failed", more.error().message);
                continue;  // a damaged frame is skipped and counted
            }
            if (*more) waiting[i] = std::move(frame);
            if (!*more) set_source_state(i, "ended", "the recording ended");
            return;
        }
    };
    for (std::size_t i = 0; i < sources.size(); ++i) {
        if (sources[i]->live()) continue;
        total += static_cast<double>(std::max<std::int64_t>(sources[i]->count(), 1));
        fetch(i);
    }
    const double start_wall = wall_clock();
    std::optional<Nanoseconds> start_time;
    double done = 0;
    while (!stop) {
        std::size_t first = sources.size();
        for (std::size_t i = 0; i < waiting.size(); ++i) {
            if (waiting[i] && (first == sources.size() || waiting[i]->time < waiting[first]->time)) first = i;
        }
        if (first == sources.size()) break;
        const Nanoseconds time = waiting[first]->time;
        if (!start_time) start_time = time;
        if (speed > 0) {
            const double due = start_wall + to_seconds(time - *start_time) / speed;
            while (!stop && wall_clock() < due) std::this_thread::sleep_for(std::chrono::duration<double>(std::min(0.05, due - wall_clock())));
        }
        tell_until(time);
        const auto fed = feed(first, waiting[first]->image, time);
        if (!fed && posts_[first]->state.frames == 0) return fed;  // the very first frame does not fit: nothing will
        if (progress) progress(std::min(1.0, ++done / total));
        fetch(first);
    }
    if (!stop) tell_until(std::numeric_limits<Nanoseconds>::max());
    return {};
}

std::vector<std::uint8_t> SiteRunner::picture_of(const std::string& camera) {
    LumaImage picture;
    {
        const std::lock_guard lock(mutex_);
        for (const auto& post : posts_) {
            if (post->camera.id == camera) picture = post->last;
        }
    }
    return picture.empty() ? std::vector<std::uint8_t>() : encode_jpeg(picture, 80);
}

}  // namespace roomfix
