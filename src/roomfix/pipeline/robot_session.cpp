#include "roomfix/pipeline/robot_session.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "roomfix/imaging/picture_stabiliser.hpp"
#include "roomfix/pipeline/background_source.hpp"
#include "roomfix/pipeline/recorded_frames.hpp"

namespace roomfix {
namespace {

/// Pictures given one by one, as one source.
class PictureList : public FrameSource {
public:
    explicit PictureList(std::vector<std::string> files) : files_(std::move(files)) {}

    Result<bool> advance(SourceFrame& frame) override {
        if (next_ == files_.size()) return false;
        frame.name = files_[next_];
        frame.time = static_cast<Nanoseconds>(next_++) * 1'000'000'000;
        return true;
    }
    Result<void> decode(SourceFrame& frame) override {
        auto source = open_source(frame.name);
        if (!source) return source.error();
        SourceFrame only;
        const auto read = (*source)->next(only);
        if (!read) return read.error();
        frame.image = std::move(only.image);
        frame.colour = std::move(only.colour);
        return {};
    }
    bool live() const override { return false; }
    std::int64_t count() const override { return static_cast<std::int64_t>(files_.size()); }

private:
    std::vector<std::string> files_;
    std::size_t next_ = 0;
};

struct Post {
    const SiteCamera* camera = nullptr;
    ColourBackground background;
    PictureStabiliser stabiliser;
};

std::vector<std::string> background_of(const Site& site, const SiteCamera& camera, const RobotSessionOptions& options) {
    if (!options.background.empty()) return options.background;
    if (!camera.background.empty()) return {resolved_path(site, camera.background)};
    return options.pictures.empty() ? std::vector{resolved_path(site, camera.source)} : options.pictures;
}

/// Is a round one of the `wanted` of all `rounds` that are evenly spread?
bool is_chosen(std::size_t round, std::size_t rounds, std::size_t wanted) {
    return wanted >= rounds || (round + 1) * wanted / rounds != round * wanted / rounds;
}

}  // namespace

Result<RobotSession> RobotSession::collect(const Site& site, const RobotSessionOptions& options, const std::atomic<bool>& stop,
                                           const std::function<void(double)>& progress) {
    RobotSession session;
    std::vector<Post> posts;
    std::vector<std::unique_ptr<FrameSource>> sources;
    for (const SiteCamera& camera : site.cameras) {
        const bool wanted = options.cameras.empty() || std::find(options.cameras.begin(), options.cameras.end(), camera.id) != options.cameras.end();
        if (!wanted || std::holds_alternative<Mount>(camera.placement) || std::holds_alternative<KnownHeight>(camera.placement)) continue;
        const auto view = fixed_view(camera);
        if (!view) return Error{fmt::format("camera {}: {}", camera.id, view.error().message)};
        auto background = learn_background(camera, background_of(site, camera, options));
        if (!background) return background.error();
        if (background->colour.empty()) return Error{fmt::format("camera {}: its background has no picture", camera.id)};
        session.views_.push_back(std::make_unique<View>(*view));
        session.cameras_.push_back(camera.id);
        Post& post = posts.emplace_back(Post{&camera, std::move(background->colour), PictureStabiliser(camera.model)});
        const ColourImage empty = post.background.picture();
        post.stabiliser.set_reference({background->grey.mean(), &empty});
        if (!options.pictures.empty()) {
            sources.push_back(std::make_unique<PictureList>(options.pictures));
        } else {
            auto source = open_source(resolved_path(site, camera.source));
            if (!source) return Error{fmt::format("camera {}: {}", camera.id, source.error().message)};
            if ((*source)->live())
                return Error{fmt::format("camera {}: {} is live: record it first, a body is learned from a recording", camera.id, camera.source)};
            sources.push_back(std::move(*source));
        }
    }
    if (posts.empty()) return Error{"the site has no fixed camera among those asked for: a body is learned from pictures of fixed cameras"};

    std::string failed;
    RecordedFrames::Listener listener;
    listener.failed = [&](std::size_t i, const std::string& message) { failed = fmt::format("camera {}: {}", posts[i].camera->id, message); };
    listener.ended = [](std::size_t) {};
    RecordedFrames frames(sources, stop, listener);
    std::int64_t longest = 1;
    for (const auto& source : sources) longest = std::max(longest, source->count());
    const auto rounds = static_cast<std::size_t>(longest);
    const std::size_t wanted = std::max<std::size_t>(options.most_frames / posts.size(), 1);
    std::size_t round_number = 0;
    for (auto round = frames.next_round(); !round.empty() && !stop; round = frames.next_round(), ++round_number) {
        BodyMoment moment;
        std::string name;
        for (const std::size_t i : round) {
            const SourceFrame frame = frames.take(i);
            if (is_chosen(std::min(round_number, rounds - 1), rounds, wanted)) {
                auto evidence = std::make_unique<Evidence>();
                evidence->with_colours = true;
                const CameraModel& model = posts[i].camera->model;
                const bool fits = frame.image.width() == model.width && frame.image.height() == model.height;
                const PictureView picture = fits ? posts[i].stabiliser.steady({frame.image, &frame.colour}) : PictureView();
                if (picture.colour == nullptr || !posts[i].background.compare(*picture.colour, *evidence)) {
                    return Error{fmt::format("camera {}: {} is {} x {} pixels, the site file says {} x {}: is it of this camera?", posts[i].camera->id,
                                             frame.name, frame.image.width(), frame.image.height(), model.width, model.height)};
                }
                if (name.empty()) name = frame.name;
                moment.cameras.push_back({session.views_[i].get(), evidence.get()});
                session.evidence_.push_back(std::move(evidence));
            }
            frames.advance(i);
        }
        if (!failed.empty()) return Error{failed};
        if (!moment.cameras.empty()) {
            session.moments_.push_back(std::move(moment));
            session.names_.push_back(name);
        }
        if (progress) progress(std::min(1.0, static_cast<double>(round_number + 1) / static_cast<double>(rounds)));
    }
    if (!failed.empty()) return Error{failed};
    if (session.moments_.empty()) return Error{"there are no pictures to learn from"};
    return session;
}

}  // namespace roomfix
