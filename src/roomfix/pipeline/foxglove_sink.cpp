#include "roomfix/pipeline/foxglove_sink.hpp"

#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "roomfix/connect/foxglove_messages.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/pipeline/camera_pipeline.hpp"

namespace roomfix {
namespace {

constexpr int picture_quality = 80;  // per cent
constexpr Nanoseconds between_pictures = 200'000'000;

FoxgloveChannel latched(FoxgloveChannel channel) {
    channel.latched = true;
    return channel;
}

}  // namespace

FoxgloveSink::FoxgloveSink(SiteTracker& tracker, std::unique_ptr<FoxgloveServer> server)
    : tracker_(tracker),
      server_(std::move(server)),
      map_(server_->add_channel(latched(scene_channel("/map")))),
      robots_(server_->add_channel(scene_channel("/robots"))),
      transforms_(server_->add_channel(transform_channel("/tf"))) {
    server_->send(map_, 0, map_scene(tracker_.site()));
    for (std::size_t c = 0; c < tracker_.cameras(); ++c) {
        const std::string& camera = tracker_.camera(c).id;
        pictures_.push_back({camera, server_->add_channel(picture_channel("/" + camera + "/image"))});
    }
}

Result<std::unique_ptr<FoxgloveSink>> FoxgloveSink::serve(SiteTracker& tracker, const WebOutput& output) {
    auto access = web_access(output, tracker.site(), "Foxglove's server");
    if (!access) return access.error();
    auto server = FoxgloveServer::start(*access, tracker.site().name);
    if (!server) return server.error();
    tracker.keep_frames();
    return std::unique_ptr<FoxgloveSink>(new FoxgloveSink(tracker, std::move(*server)));
}

std::string FoxgloveSink::name() const { return fmt::format("Foxglove at port {}", server_->port()); }

/// Those that somebody looks at, not oftener than a screen needs them.
void FoxgloveSink::send_pictures() {
    for (PictureChannel& picture : pictures_) {
        if (!server_->is_wanted(picture.channel)) continue;
        const auto shown = tracker_.shown_frame(picture.camera);
        if (!shown || (picture.last > 0 && shown->time - picture.last < between_pictures)) continue;
        picture.last = shown->time;
        server_->send(picture.channel, shown->time, picture_message(picture.camera, shown->time, encode_jpeg(shown->picture, picture_quality)));
    }
}

Result<void> FoxgloveSink::give(const FixBatch& batch) {
    for (const Fix& fix : batch.given) {
        if (fix.status == FixStatus::none || fix.robot.empty() || fix.unknown) continue;
        const auto known = poses_.find(fix.robot);
        const std::size_t channel = known != poses_.end() ? known->second : server_->add_channel(pose_channel("/" + fix.robot + "/pose"));
        poses_[fix.robot] = channel;
        server_->send(channel, fix.time, pose_message(fix));
        server_->send(transforms_, fix.time, transform_message(fix));
    }
    server_->send(robots_, batch.time, robots_scene(tracker_.site(), batch.all, batch.time));
    send_pictures();
    return {};
}

SinkState FoxgloveSink::state() const { return {name(), "ok", "", server_->missed()}; }

}  // namespace roomfix
