#include "roomfix/pipeline/site_sinks.hpp"

#include "roomfix/pipeline/foxglove_sink.hpp"
#include "roomfix/pipeline/history_sink.hpp"
#include "roomfix/pipeline/mqtt_sink.hpp"
#include "roomfix/pipeline/ros2_sink.hpp"
#include "roomfix/pipeline/tum_folder.hpp"

namespace roomfix {

/// Adds what was opened; its error if it could not be.
template <class Sink>
static Result<void> add(SourceRunner& runner, Result<std::unique_ptr<Sink>> opened, Overflow overflow) {
    if (!opened) return opened.error();
    runner.add_sink(std::move(*opened), overflow);
    return {};
}

Result<void> add_site_sinks(SourceRunner& runner, SiteTracker& tracker, Overflow overflow, const std::function<void(const std::string&)>& on_trouble) {
    const Site& site = tracker.site();
    const Outputs& outputs = site.outputs;
    Result<void> added;
    if (!outputs.tum.empty()) added = add(runner, TumFolder::open(resolved_path(site, outputs.tum)), overflow);
    if (added && outputs.mqtt) added = add(runner, MqttSink::open(site, *outputs.mqtt), overflow);
    if (added && outputs.ros2) added = add(runner, Ros2Sink::open(tracker, *outputs.ros2), Overflow::drop_oldest);
    if (added && outputs.history) added = add(runner, open_history(site, on_trouble), Overflow::wait);  // it never stands still
    // What is only looked at may miss moments.
    if (added && outputs.foxglove) added = add(runner, FoxgloveSink::serve(tracker, *outputs.foxglove), Overflow::newest_only);
    return added;
}

}  // namespace roomfix
