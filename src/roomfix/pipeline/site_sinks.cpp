#include "roomfix/pipeline/site_sinks.hpp"

#include "roomfix/pipeline/mqtt_sink.hpp"

namespace roomfix {

Result<void> add_site_sinks(SourceRunner& runner, const Site& site, Overflow overflow) {
    if (site.outputs.mqtt) {
        auto mqtt = MqttSink::open(site, *site.outputs.mqtt);
        if (!mqtt) return mqtt.error();
        runner.add_sink(std::move(*mqtt), overflow);
    }
    return {};
}

}  // namespace roomfix
