#include "roomfix/pipeline/site_runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <optional>
#include <thread>

#include "roomfix/connect/fix_json.hpp"
#include "roomfix/imaging/load_luma.hpp"

namespace roomfix {
namespace {

constexpr double publish_interval = 0.06;  // s: a screen needs no more

double wall_clock() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace

SiteRunner::SiteRunner(const Site& site) : site_(site), smoother_(site.robots) {}

Result<std::unique_ptr<SiteRunner>> SiteRunner::create(const Site& site) {
    std::unique_ptr<SiteRunner> runner(new SiteRunner(site));
    for (const SiteCamera& camera : site.cameras) {
        const bool fixed = std::holds_alternative<KnownPose>(camera.placement) || std::holds_alternative<KnownFloorPoints>(camera.placement);
        if (!fixed) continue;
        const auto view = fixed_view(camera);
        if (!view) return view.error();
        auto post = std::make_unique<Post>();
        post->camera = camera;
        post->state.id = camera.id;
        post->observer = std::make_unique<OverheadObserver>(*view, site.robots);
        runner->posts_.push_back(std::move(post));
    }
    if (runner->posts_.empty()) return Error{"the site has no fixed camera: give a camera 'pose' or 'floor_points'"};
    if (site.robots.empty()) return Error{"the site has no robot: add one under 'robots' with its shape and size"};
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

void SiteRunner::set_background(std::size_t index, BackgroundModel background) { posts_[index]->observer->set_background(std::move(background)); }

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
    post.observer->observe(frame, post.result);
    const double after = wall_clock();

    const std::lock_guard lock(mutex_);
    SourceState& state = post.state;
    ++state.frames;
    state.status = "ok";
    state.message = post.result.reason;
    state.busy = state.frames == 1 ? after - before : 0.9 * state.busy + 0.1 * (after - before);
    if (post.last_wall > 0) {
        const double rate = 1 / std::max(after - post.last_wall, 1e-4);
        state.rate = state.rate == 0 ? rate : 0.9 * state.rate + 0.1 * rate;
    }
    post.last_wall = after;
    if (page_) {
        post.last = copy_of(frame);
        post.shown = post.result.observations;
    }
    smoother_.add(time, post.camera.id, post.result.observations);
    pass_on(time, post.camera.id);
    return {};
}

/// Gives the fixes of a time to the file and, not too often, to the page. The mutex is held.
void SiteRunner::pass_on(Nanoseconds time, const std::string& camera) {
    const std::vector<Fix> fixes = smoother_.fixes(time);
    for (const Fix& fix : fixes) {
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
    std::vector<std::thread> threads;
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
        const auto fed = feed(first, waiting[first]->image, time);
        if (!fed && posts_[first]->state.frames == 0) return fed;  // the very first frame does not fit: nothing will
        if (progress) progress(std::min(1.0, ++done / total));
        fetch(first);
    }
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
