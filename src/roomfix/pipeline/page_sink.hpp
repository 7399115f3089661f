// The page as a sink: what it shows is made in the sink's own thread, not oftener than a screen needs it.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "roomfix/connect/web_server.hpp"
#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/pipeline/site_tracker.hpp"
#include "roomfix/pipeline/zone_watch.hpp"

namespace roomfix {

class SourceRunner;

class PageSink final : public FixSink {
public:
    /// Serves the page from now on. `tracker`, which keeps its frames from now on, must outlive it. `runner`, if there is one, says how sinks
    /// and senses fare; it must outlive the page, too. An error if the address is taken or not ours, or others could look who must not.
    static Result<std::unique_ptr<PageSink>> serve(SiteTracker& tracker, const WebOutput& web, const SourceRunner* runner = nullptr);

    std::string name() const override { return "the page"; }
    int port() const { return server_.port(); }
    /// From now on /api/history is answered.
    void show_history(WebAnswerer answerer) { server_.add_route("/api/history", std::move(answerer)); }
    Result<void> give(const FixBatch& batch) override;

private:
    PageSink(SiteTracker& tracker, const SourceRunner* runner) : tracker_(tracker), runner_(runner), zones_(tracker.site().zones) {}
    std::string site_json() const;
    std::string state_json(const FixBatch& batch) const;
    std::vector<std::uint8_t> picture_of(const std::string& camera) const;

    std::string metrics() const;

    SiteTracker& tracker_;
    const SourceRunner* runner_;
    mutable std::mutex mutex_;  // guards:
    std::vector<Fix> newest_;   // of each robot
    ZoneWatch zones_;           // of the sink's thread
    WebServer server_;
};

}  // namespace roomfix
