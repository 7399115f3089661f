// The page as a sink: what it shows is made in the sink's own thread, not oftener than a screen needs it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "roomfix/connect/web_server.hpp"
#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/pipeline/site_tracker.hpp"

namespace roomfix {

class PageSink final : public FixSink {
public:
    /// Serves the page from now on. `tracker`, which keeps its frames from now on, must outlive it. An error if the address is taken or not ours.
    static Result<std::unique_ptr<PageSink>> serve(SiteTracker& tracker, const std::string& host, int port);

    std::string name() const override { return "the page"; }
    int port() const { return server_.port(); }
    Result<void> give(const FixBatch& batch) override;

private:
    explicit PageSink(SiteTracker& tracker) : tracker_(tracker) {}
    std::string site_json() const;
    std::string state_json(const FixBatch& batch) const;
    std::vector<std::uint8_t> picture_of(const std::string& camera) const;

    SiteTracker& tracker_;
    WebServer server_;
};

}  // namespace roomfix
