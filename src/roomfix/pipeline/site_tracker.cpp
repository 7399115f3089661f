// The door alone: what it does stands in site_tracker_impl.cpp.
#include "roomfix/pipeline/site_tracker.hpp"

#include <algorithm>
#include <utility>

#include "roomfix/base/steady_now.hpp"
#include "roomfix/pipeline/site_tracker_impl.hpp"

namespace roomfix {

SiteTracker::SiteTracker(const Site& site) : impl_(std::make_unique<Impl>(site)) {}
SiteTracker::~SiteTracker() = default;

Result<std::unique_ptr<SiteTracker>> SiteTracker::create(const Site& site) {
    if (site.robots.empty()) return Error{"the site has no robot: add one under 'robots' with its shape and size"};
    std::unique_ptr<SiteTracker> tracker(new SiteTracker(site));
    for (const SiteCamera& camera : site.cameras) {
        if (auto added = tracker->impl_->add_camera(camera); !added) return added.error();
    }
    const auto senses = [](const SiteRobot& robot) { return !robot.receivers.empty() || robot.detector; };
    if (tracker->cameras() == 0 && std::none_of(site.robots.begin(), site.robots.end(), senses)) {
        return Error{"the site has nothing that finds robots: give a camera 'pose', 'floor_points' or 'mount', or a robot a 'receiver' or a 'detector'"};
    }
    return tracker;
}

const Site& SiteTracker::site() const { return impl_->site_; }
std::size_t SiteTracker::cameras() const { return impl_->cameras_.size(); }
const SiteCamera& SiteTracker::camera(std::size_t index) const { return impl_->camera(index); }
const CameraPipeline& SiteTracker::pipeline(std::size_t index) const { return *impl_->cameras_[index]->pipeline; }
bool SiteTracker::is_fixed(std::size_t index) const { return impl_->is_fixed(index); }

void SiteTracker::set_background(std::size_t index, BackgroundModel background, ColourBackground colour) {
    if (FixedCamera* fixed = impl_->cameras_[index]->pipeline->fixed()) fixed->set_background(std::move(background), std::move(colour));
}

void SiteTracker::on_fixes(std::function<void(const FixBatch&)> listener) { impl_->delivery_.add_listener(std::move(listener)); }
void SiteTracker::on_camera_status(std::function<void(const CameraState&)> listener) { impl_->status_listener_ = std::move(listener); }
void SiteTracker::on_line_problem(std::function<void(const std::string&)> listener) { impl_->line_problems_.on_problem(std::move(listener)); }
void SiteTracker::before_frames(std::function<void(Nanoseconds)> sensed) { impl_->sensed_until_ = std::move(sensed); }

Result<void> SiteTracker::process(const CameraFrame& frame) {
    WorkerPool alone(1);
    return impl_->process({frame}, alone);
}

Result<void> SiteTracker::process(const std::vector<CameraFrame>& frames, WorkerPool& pool) { return impl_->process(frames, pool); }

void SiteTracker::process(const RangeBatch& batch) {
    if (impl_->tap_.ranges) impl_->tap_.ranges(batch);
    impl_->process(batch);
}

void SiteTracker::process(const SightingBatch& batch) {
    if (impl_->tap_.sightings) impl_->tap_.sightings(batch);
    impl_->process(batch);
}

void SiteTracker::process(const OdometryBatch& batch) {
    if (impl_->tap_.odometry) impl_->tap_.odometry(batch);
    impl_->process(batch);
}

void SiteTracker::tap_senses(SenseTap tap) { impl_->tap_ = std::move(tap); }

void SiteTracker::go_on(Nanoseconds time) {
    const std::lock_guard lock(impl_->mutex_);
    impl_->tracker_.go_on(time);
}

std::vector<Fix> SiteTracker::fixes(Nanoseconds time) const {
    const std::lock_guard lock(impl_->mutex_);
    return impl_->tracker_.fixes(time);
}

void SiteTracker::measure_latency(const Pace& pace) { impl_->delivery_.measure_latency(pace); }
bool SiteTracker::measures_latency() const { return impl_->delivery_.measures_latency(); }
void SiteTracker::keep_frames() { impl_->keeps_frames_ = true; }
SiteSnapshot SiteTracker::snapshot(Nanoseconds time) const { return impl_->snapshot(time); }
std::shared_ptr<const ShownFrame> SiteTracker::shown_frame(const std::string& camera) const { return impl_->shown_frame(camera); }

void SiteTracker::set_camera_state(std::size_t index, const std::string& status, const std::string& message) {
    impl_->set_camera_state(index, status, message);
}
void SiteTracker::note_source(std::size_t index, const std::string& note) { impl_->note_source(index, note); }
void SiteTracker::count_dropped(std::size_t index, long came, long dropped) { impl_->count_dropped(index, came, dropped); }
std::vector<CameraState> SiteTracker::camera_states() const { return impl_->camera_states(); }

void SiteTracker::add_problems(const std::vector<std::string>& problems) { impl_->line_problems_.note(problems, steady_now()); }
void SiteTracker::finish_line_problems() { impl_->line_problems_.finish(); }

std::vector<std::string> SiteTracker::robots_not_found() const { return impl_->robots_not_found(); }
StageTimes& SiteTracker::stage_times() { return impl_->times_; }
const StageTimes& SiteTracker::stage_times() const { return impl_->times_; }

void SiteTracker::keep_history() {
    const std::lock_guard lock(impl_->mutex_);
    impl_->tracker_.keep_history();
}

const Tracker& SiteTracker::tracker() const { return impl_->tracker_; }

TrackerCounts SiteTracker::tracker_counts() const {
    const std::lock_guard lock(impl_->mutex_);
    return impl_->tracker_.counts();
}

}  // namespace roomfix
