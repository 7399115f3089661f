// Poses, ellipses, map and pictures to whoever looks with Foxglove.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "roomfix/connect/foxglove_server.hpp"
#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/pipeline/site_tracker.hpp"

namespace roomfix {

class FoxgloveSink final : public FixSink {
public:
    /// Serves from now on. `tracker`, which keeps its frames from now on, must outlive it. An error as of FoxgloveServer::start().
    static Result<std::unique_ptr<FoxgloveSink>> serve(SiteTracker& tracker, const WebOutput& output);

    std::string name() const override;
    Result<void> give(const FixBatch& batch) override;
    SinkState state() const override;

private:
    struct PictureChannel {
        std::string camera;
        std::size_t channel = 0;
        Nanoseconds last = 0;  // frame that was sent
    };
    FoxgloveSink(SiteTracker& tracker, std::unique_ptr<FoxgloveServer> server);
    void send_pictures();

    SiteTracker& tracker_;
    std::unique_ptr<FoxgloveServer> server_;
    std::size_t map_, robots_, transforms_;
    std::map<std::string, std::size_t> poses_;  // channel of each robot
    std::vector<PictureChannel> pictures_;
};

}  // namespace roomfix
