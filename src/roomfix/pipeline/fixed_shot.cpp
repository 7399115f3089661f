#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/overlay.hpp"
#include "roomfix/overhead/li2014.hpp"
#include "roomfix/overhead/overhead_observer.hpp"
#include "roomfix/overhead/robot_tag.hpp"
#include "roomfix/pipeline/background_source.hpp"
#include "roomfix/pipeline/single_shot.hpp"

namespace roomfix {
namespace {

constexpr std::size_t enough_to_learn = 10;  // images that are their own background

/// The site's method or the paper's, behind one call: the fixes of a picture.
class SingleShot {
public:
    SingleShot(const Site& site, const SiteCamera& camera, const View& view, LearnedBackground background)
        : site_(site), camera_(camera.id), observer_(view, site.robots), tags_(site.tag_families()) {
        observer_.set_walls(site.walls);
        observer_.set_background(std::move(background.grey), std::move(background.colour));
    }

    Result<void> use_published(const std::vector<LumaImage>& empty) {
        const auto rectangle = li2014_rectangle_ahead(observer_.view());
        if (!rectangle) return Error{"the published method needs a camera that sees the floor ahead of it"};
        auto made = Li2014::set_up(observer_.view().model, *rectangle, li2014_aisle_ahead(observer_.view()));
        if (!made) return made.error();
        published_ = std::move(*made);
        published_->set_background(empty);
        return {};
    }

    std::vector<Fix> fixes(const std::string& image, const PictureView& frame) {
        if (published_) return {published_fix(image, frame.grey)};
        observer_.observe(frame, result_);
        // A tag says more than an outline: it names the robot and its front.
        std::vector<Fix> fixes;
        std::vector<int> tagged;
        for (const TaggedRobot& robot : find_tagged_robots(observer_.view(), site_.robots, tags_, frame.grey)) {
            Fix fix = empty_fix(image, "");
            fix.status = FixStatus::ok;
            fix.robot = site_.robots[static_cast<std::size_t>(robot.robot)].id;
            fix.pose = robot.fit.pose;
            fix.covariance = robot.fit.covariance;
            fix.sources = {camera_};
            fixes.push_back(fix);
            tagged.push_back(robot.robot);
        }
        for (const SilhouetteObservation& o : result_.observations) {
            if (std::find(tagged.begin(), tagged.end(), o.robot) != tagged.end()) continue;
            Fix fix = empty_fix(image, "");
            fix.status = FixStatus::ok;
            fix.robot = site_.robots[static_cast<std::size_t>(o.robot)].id;
            fix.pose = o.pose;
            fix.yaw_known = o.yaw_known;
            fix.covariance = o.covariance;
            fix.sources = {camera_};
            fix.hypotheses.assign(o.hypotheses.begin(), o.hypotheses.end());
            fixes.push_back(fix);
        }
        if (fixes.empty()) fixes.push_back(empty_fix(image, result_.reason));
        return fixes;
    }
    const OverheadResult& result() const { return result_; }
    const View& view() const { return observer_.view(); }

private:
    Fix published_fix(const std::string& image, LumaView frame) {
        const auto place = published_->locate(frame);
        if (!place) return empty_fix(image, "the published method found no blob in the difference image");
        Fix fix = empty_fix(image, "");
        fix.status = FixStatus::ok;
        fix.robot = site_.robots[0].id;
        fix.pose = {place->x(), place->y(), 0};
        fix.yaw_known = false;
        // The paper gives no uncertainty; its own Table 1 has an error of 9 cm rms.
        fix.covariance = Eigen::Vector3d(0.065 * 0.065, 0.065 * 0.065, 3.29).asDiagonal();
        fix.sources = {camera_};
        return fix;
    }

    Site site_;
    std::string camera_;
    OverheadObserver observer_;
    OverheadResult result_;
    TagDetector tags_;
    std::optional<Li2014> published_;
};

Result<std::vector<LumaImage>> load_frames(const std::vector<std::string>& sources) {
    std::vector<LumaImage> frames;
    for (const std::string& name : sources) {
        auto source = open_source(name);
        if (!source) return source.error();
        SourceFrame frame;
        while (frames.size() < 150) {
            const auto more = (*source)->next(frame);
            if (!more) return more.error();
            if (!*more) break;
            frames.push_back(std::move(frame.image));
        }
    }
    return frames;
}

}  // namespace

Result<Shot> prepare_fixed_shot(const Site& site, const SiteCamera& camera, const ShotOptions& options) {
    const auto view = fixed_view(camera);
    if (!view) return view.error();
    auto sources = background_sources(site, camera, options.background);
    if (sources.empty() && options.images.size() >= enough_to_learn) sources = options.images;
    if (sources.empty()) {
        return Error{
            fmt::format("camera {} has no background to compare with: give pictures without robots by --background, or 'background' in the site "
                        "file (or {} pictures or more at once)",
                        camera.id, enough_to_learn)};
    }
    auto background = learn_background(camera, sources);
    if (!background) return background.error();
    const auto single = std::make_shared<SingleShot>(site, camera, *view, std::move(*background));
    if (options.published) {
        const auto frames = load_frames(sources);
        if (!frames) return frames.error();
        if (auto used = single->use_published(*frames); !used) return used.error();
    }
    Shot shot;
    shot.model = camera.model;
    shot.fixes = [single](const std::string& image, const PictureView& frame) { return single->fixes(image, frame); };
    shot.overlay = [single, robots = site.robots](const std::filesystem::path& file, LumaView frame) {
        std::vector<std::string> labels;
        for (const auto& o : single->result().observations) {
            labels.push_back(fmt::format("{} ({:.2f}, {:.2f})", robots[static_cast<std::size_t>(o.robot)].id, o.pose.x, o.pose.y));
        }
        return save_overlay(file, frame, single->view(), single->result().observations, labels);
    };
    return shot;
}

}  // namespace roomfix
