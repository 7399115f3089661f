// The page as a sink: what it shows is made in the sink's own thread, not oftener than a screen needs it.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "roomfix/connect/plan_picture.hpp"
#include "roomfix/connect/web_server.hpp"
#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/pipeline/history_sink.hpp"
#include "roomfix/pipeline/site_tracker.hpp"

namespace roomfix {

class SourceRunner;

class PageSink final : public FixSink {
public:
    /// Serves the page from now on. `tracker`, which keeps its frames from now on, must outlive it, and `runner`, which says how sinks and senses fare, too.
    /// `site_file`: that zones which are drawn on the page go into; empty: none are. An error if the address is taken or not ours, others could look who must
    /// not, or the site's plan cannot be shown.
    static Result<std::unique_ptr<PageSink>> serve(SiteTracker& tracker, const WebOutput& web, const SourceRunner& runner, const std::string& site_file = "");

    std::string name() const override { return "the page"; }
    int port() const { return server_.port(); }
    /// From now on /api/history and /api/history/zones are answered.
    void show_history(HistoryAnswerers answerers);
    Result<void> give(const FixBatch& batch) override;

private:
    PageSink(SiteTracker& tracker, const SourceRunner& runner) : tracker_(tracker), runner_(runner) {}
    void add_routes(const std::string& site_file);
    void show_site();
    std::string state_json(const FixBatch& batch) const;
    WebAnswer picture_of(const std::string& camera) const;
    WebAnswer robot(const std::string& id) const;
    std::string metrics() const;

    SiteTracker& tracker_;
    const SourceRunner& runner_;
    std::optional<PlanPicture> plan_;
    int zones_version_ = 0;          // of what /api/site says; of the sink's thread
    std::int64_t site_version_ = 0;  // likewise: ms of the clock when it was made
    mutable std::mutex mutex_;       // guards:
    FixBatch newest_;
    WebServer server_;
};

}  // namespace roomfix
