#include "roomfix/pipeline/metrics.hpp"

#include <fmt/format.h>

#include "roomfix/base/number.hpp"
#include "roomfix/estimate/belief.hpp"
#include "roomfix/estimate/tracker.hpp"

namespace roomfix {
namespace {

/// A label's value with what the format wants escaped.
std::string label(const std::string& name, const std::string& value) {
    std::string text = name + "=\"";
    for (const char c : value) {
        if (c == '\n') {
            text += "\\n";
            continue;
        }
        if (c == '\\' || c == '"') text += '\\';
        text += c;
    }
    return text + "\"";
}

/// One name with its values, each with its labels.
class Metric {
public:
    Metric(std::string name, const char* type, const char* help) : name_(std::move(name)) {
        text_ = fmt::format("# HELP {} {}\n# TYPE {} {}\n", name_, help, name_, type);
    }
    void add(const std::string& labels, double value) {
        text_ += labels.empty() ? name_ : name_ + "{" + labels + "}";
        text_ += " " + number_text(value) + "\n";
    }
    const std::string& text() const { return text_; }

private:
    std::string name_, text_;
};

std::string camera_metrics(const std::vector<CameraState>& cameras) {
    Metric up("roomfix_camera_up", "gauge", "1 while the camera gives frames that are used, else 0");
    Metric frames("roomfix_camera_frames_total", "counter", "frames that were looked at");
    Metric bad("roomfix_camera_bad_frames_total", "counter", "frames that could not be used");
    Metric dropped("roomfix_camera_dropped_frames_total", "counter", "frames that came but were not looked at for want of time");
    Metric rate("roomfix_camera_rate_hertz", "gauge", "frames per second");
    Metric busy("roomfix_camera_busy_seconds", "gauge", "time that one frame takes");
    for (const CameraState& camera : cameras) {
        const std::string of = label("camera", camera.id);
        up.add(of, camera.status == "ok" || camera.status == "slow" ? 1 : 0);
        frames.add(of, static_cast<double>(camera.frames));
        bad.add(of, static_cast<double>(camera.bad_frames));
        dropped.add(of, static_cast<double>(camera.dropped));
        rate.add(of, camera.rate);
        busy.add(of, camera.busy);
    }
    return up.text() + frames.text() + bad.text() + dropped.text() + rate.text() + busy.text();
}

std::string robot_metrics(const std::vector<Fix>& robots) {
    Metric located("roomfix_robot_located", "gauge", "1 while the robot is seen, 0.5 while its place is predicted only, 0 while it is lost");
    Metric sigma("roomfix_robot_sigma_metres", "gauge", "standard deviation of the robot's place along the worst direction");
    Metric unknown("roomfix_unknown_objects", "gauge", "things on the floor that are no robot of the site");
    double others = 0;
    for (const Fix& fix : robots) {
        if (fix.unknown) {
            others += fix.status == FixStatus::none ? 0 : 1;
            continue;
        }
        const std::string of = label("robot", fix.robot);
        located.add(of, fix.status == FixStatus::ok ? 1 : fix.status == FixStatus::coasting ? 0.5 : 0);
        if (fix.status == FixStatus::none) continue;
        sigma.add(of, worst_sigma(fix.covariance.topLeftCorner<2, 2>()));
    }
    unknown.add("", others);
    return located.text() + sigma.text() + unknown.text();
}

std::string stage_metrics(const StageTimes& times) {
    Metric seconds("roomfix_stage_seconds", "summary", "time from a frame to its fix, by stage");
    for (std::size_t s = 0; s < stages; ++s) {
        const StageSummary stage = times.summary(static_cast<Stage>(s));
        if (stage.count == 0) continue;
        const std::string of = label("stage", name_of(static_cast<Stage>(s)));
        seconds.add(of + ",quantile=\"0.5\"", stage.median);
        seconds.add(of + ",quantile=\"0.95\"", stage.p95);
        seconds.add(of + ",quantile=\"0.99\"", stage.p99);
    }
    return seconds.text();
}

std::string sink_metrics(const std::vector<SinkState>& sinks) {
    Metric up("roomfix_sink_up", "gauge", "1 while fixes can be passed on there, else 0");
    Metric lost("roomfix_sink_lost_total", "counter", "messages that could not be passed on");
    for (const SinkState& sink : sinks) {
        up.add(label("sink", sink.name), sink.status == "ok" ? 1 : 0);
        lost.add(label("sink", sink.name), static_cast<double>(sink.lost));
    }
    return up.text() + lost.text();
}

std::string tracker_metrics(const TrackerCounts& counts) {
    Metric unused("roomfix_observations_not_used_total", "counter", "observations that the tracker could not use, by reason");
    unused.add(label("reason", "late"), static_cast<double>(counts.late));
    unused.add(label("reason", "impossible"), static_cast<double>(counts.impossible));
    unused.add(label("reason", "strayed"), static_cast<double>(counts.strayed));
    return unused.text();
}

}  // namespace

std::string metrics_text(const SiteTracker& tracker, const std::vector<Fix>& robots, const std::vector<SinkState>& sinks) {
    return camera_metrics(tracker.camera_states()) + robot_metrics(robots) + stage_metrics(tracker.stage_times()) + sink_metrics(sinks) +
           tracker_metrics(tracker.tracker_counts());
}

}  // namespace roomfix
