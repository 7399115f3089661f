#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/ceiling/kim2011.hpp"
#include "roomfix/ceiling/lamps.hpp"
#include "roomfix/connect/fix_json.hpp"
#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/overlay.hpp"
#include "roomfix/connect/range_source.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/overhead/li2014.hpp"
#include "roomfix/overhead/overhead_observer.hpp"
#include "roomfix/overhead/robot_tag.hpp"
#include "roomfix/pipeline/background_source.hpp"
#include "roomfix/pipeline/onboard_locator.hpp"
#include "roomfix/site/load_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string site;
    std::string camera;
    std::vector<std::string> images;
    std::vector<std::string> background;
    std::string method = "ours";
    std::string overlay;
    std::string ranges;
    std::string landmark;
};

/// A camera ready to make fixes of pictures.
struct Shot {
    CameraModel model;
    std::function<std::vector<Fix>(const std::string& image, LumaView frame)> fixes;
    std::function<Result<void>(const std::filesystem::path& file, LumaView frame)> overlay;  // of the last picture
};

constexpr std::size_t enough_to_learn = 10;  // images that are their own background

Fix empty_fix(const std::string& image, const std::string& reason) {
    Fix fix;
    const auto stamp = parse_integer(std::filesystem::path(image).stem().string());
    fix.time = stamp.value_or(0);
    fix.image = image;
    fix.reason = reason;
    return fix;
}

/// The site's method or the paper's, behind one call: the fixes of a picture.
class SingleShot {
public:
    SingleShot(const Site& site, const SiteCamera& camera, const View& view, BackgroundModel background)
        : site_(site), camera_(camera.id), observer_(view, site.robots) {
        observer_.set_background(std::move(background));
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

    std::vector<Fix> fixes(const std::string& image, LumaView frame) {
        if (published_) return {published_fix(image, frame)};
        observer_.observe(frame, result_);
        // A tag says more than an outline: it names the robot and its front.
        std::vector<Fix> fixes;
        std::vector<int> tagged;
        for (const TaggedRobot& robot : find_tagged_robots(observer_.view(), site_.robots, tags_, frame)) {
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

std::vector<std::string> background_sources(const Site& site, const SiteCamera& camera, const Arguments& arguments) {
    if (!arguments.background.empty()) return arguments.background;
    if (!camera.background.empty()) return {resolved_path(site, camera.background)};
    return arguments.images.size() >= enough_to_learn ? arguments.images : std::vector<std::string>();
}

Result<Shot> prepare_fixed(const Site& site, const SiteCamera& camera, const Arguments& arguments) {
    const auto view = fixed_view(camera);
    if (!view) return view.error();
    const auto sources = background_sources(site, camera, arguments);
    if (sources.empty()) {
        return Error{
            fmt::format("camera {} has no background to compare with: give pictures without robots by --background, or 'background' in the site "
                        "file (or {} pictures or more at once)",
                        camera.id, enough_to_learn)};
    }
    auto background = learn_background(camera, sources);
    if (!background) return background.error();
    const auto single = std::make_shared<SingleShot>(site, camera, *view, std::move(*background));
    if (arguments.method == "published") {
        const auto frames = load_frames(sources);
        if (!frames) return frames.error();
        if (auto used = single->use_published(*frames); !used) return used.error();
    }
    Shot shot;
    shot.model = camera.model;
    shot.fixes = [single](const std::string& image, LumaView frame) { return single->fixes(image, frame); };
    shot.overlay = [single, robots = site.robots](const std::filesystem::path& file, LumaView frame) {
        std::vector<std::string> labels;
        for (const auto& o : single->result().observations) {
            labels.push_back(fmt::format("{} ({:.2f}, {:.2f})", robots[static_cast<std::size_t>(o.robot)].id, o.pose.x, o.pose.y));
        }
        return save_overlay(file, frame, single->view(), single->result().observations, labels);
    };
    return shot;
}

/// A camera on a robot: landmarks, and the ranges of the moment.
class OnboardShot {
public:
    OnboardShot(const Site& site, const SiteCamera& camera, std::unique_ptr<OnboardLocator> locator)
        : site_(site), camera_(camera), locator_(std::move(locator)) {}

    Result<void> use_landmark(const std::string& id) {
        for (std::size_t i = 0; i < site_.landmarks.size(); ++i) {
            if (site_.landmarks[i].id == id) landmark_ = static_cast<int>(i);
        }
        if (landmark_ < 0) return Error{fmt::format("--landmark {}: the site has no such landmark", id)};
        return {};
    }
    Result<void> use_ranges(const std::string& file) {
        auto batch = load_ranges(file, site_, locator_->robot());
        if (!batch) return batch.error();
        for (const std::string& problem : batch->problems) say(problem);
        ranges_ = std::move(batch->ranges);
        return {};
    }
    Result<void> use_published() {
        const int index = landmark_ >= 0 ? landmark_ : 0;
        if (site_.landmarks.empty() || !std::holds_alternative<LedTriangle>(site_.landmarks[static_cast<std::size_t>(index)].kind)) {
            return Error{"the published method needs a landmark of three LEDs: add one, or choose it by --landmark"};
        }
        published_landmark_ = index;
        published_ = std::make_unique<Kim2011>(site_.landmarks[static_cast<std::size_t>(index)], std::get<Mount>(camera_.placement));
        return {};
    }

    std::vector<Fix> fixes(const std::string& image, LumaView frame) {
        const auto stamp = parse_integer(std::filesystem::path(image).stem().string());
        const auto ranges = ranges_at(stamp);
        locator_->locate(&frame, ranges, std::nullopt, landmark_, result_);
        if (published_) return {published_fix(image, frame, ranges)};
        std::vector<std::string> sources = {camera_.id};
        if (!ranges.empty()) sources.emplace_back("ranges");
        Fix fix = locator_->fix_of(result_, stamp.value_or(0), sources);
        fix.image = image;
        return {fix};
    }
    Result<void> overlay(const std::filesystem::path& file, LumaView frame) const {
        CeilingOverlay drawn;
        drawn.landmarks = result_.seen.landmarks;
        drawn.names = locator_->landmark_names(result_);
        for (const RejectedSpot& spot : result_.seen.rejected) drawn.rejected.push_back(spot.pixel);
        for (const LampBox& lamp : find_lamps(frame)) drawn.lamps.push_back({lamp.left, lamp.top, lamp.right, lamp.bottom});
        drawn.caption = result_.located.reason;
        if (!result_.located.places.empty()) {
            const RobotPlace& place = result_.located.places[0];
            drawn.caption = fmt::format("x {:.3f} m, y {:.3f} m, yaw {:.1f} deg, +- {:.1f} mm", place.pose.x, place.pose.y, degrees(place.pose.yaw),
                                        1e3 * std::sqrt(place.covariance(0, 0) + place.covariance(1, 1)));
        }
        return save_ceiling_overlay(file, frame, drawn);
    }

private:
    /// The newest range to each beacon around a picture's time; of pictures without a time, the newest of all.
    std::vector<RangeObservation> ranges_at(std::optional<Nanoseconds> time) const {
        constexpr double age = 0.5;  // s
        std::map<int, RangeObservation> newest;
        for (const RangeObservation& range : ranges_) {
            if (range.robot == locator_->robot() && (!time || std::abs(to_seconds(range.time - *time)) < age)) newest[range.beacon] = range;
        }
        std::vector<RangeObservation> ranges;
        for (const auto& [beacon, range] : newest) ranges.push_back(range);
        return ranges;
    }
    Fix published_fix(const std::string& image, LumaView frame, const std::vector<RangeObservation>& ranges) {
        const SiteLandmark& landmark = site_.landmarks[static_cast<std::size_t>(published_landmark_)];
        const SiteRobot& robot = site_.robots[static_cast<std::size_t>(locator_->robot())];
        std::optional<double> distance;
        for (const RangeObservation& range : ranges) {
            if (site_.beacons[static_cast<std::size_t>(range.beacon)].id == landmark.beacon) distance = range.range;
        }
        const double height = landmark.map_from_landmark.translation().z() - robot.receiver.value_or(Receiver{}).position.z();
        std::string reason;
        const auto found = published_->locate(frame, distance, height, &reason);
        if (!found) return empty_fix(image, reason);
        Fix fix = empty_fix(image, "");
        fix.status = FixStatus::ok;
        fix.robot = robot.id;
        fix.pose = found->pose;
        // The paper gives no uncertainty; its own Table 1 has 2.3 cm rms.
        fix.covariance = Eigen::Vector3d(0.016 * 0.016, 0.016 * 0.016, 0.02 * 0.02).asDiagonal();
        fix.sources = {camera_.id};
        return fix;
    }

    Site site_;
    SiteCamera camera_;
    std::unique_ptr<OnboardLocator> locator_;
    OnboardResult result_;
    std::vector<RangeObservation> ranges_;
    std::unique_ptr<Kim2011> published_;
    int landmark_ = -1;
    int published_landmark_ = 0;
};

Result<Shot> prepare_onboard(const Site& site, const SiteCamera& camera, const Arguments& arguments) {
    auto locator = OnboardLocator::for_camera(site, camera);
    if (!locator) return locator.error();
    const auto onboard = std::make_shared<OnboardShot>(site, camera, std::move(*locator));
    if (!arguments.landmark.empty()) {
        if (auto used = onboard->use_landmark(arguments.landmark); !used) return used.error();
    }
    if (!arguments.ranges.empty()) {
        if (auto used = onboard->use_ranges(arguments.ranges); !used) return used.error();
    }
    if (arguments.method == "published") {
        if (auto used = onboard->use_published(); !used) return used.error();
    }
    Shot shot;
    shot.model = camera.model;
    shot.fixes = [onboard](const std::string& image, LumaView frame) { return onboard->fixes(image, frame); };
    shot.overlay = [onboard](const std::filesystem::path& file, LumaView frame) { return onboard->overlay(file, frame); };
    return shot;
}

Result<Shot> prepare(const Site& site, const Arguments& arguments) {
    const SiteCamera* camera = site.camera(arguments.camera);
    if (!camera) {
        std::vector<std::string> ids;
        for (const auto& c : site.cameras) ids.push_back(c.id);
        return Error{fmt::format("there is no camera '{}' in {}: it has {}", arguments.camera, arguments.site, fmt::join(ids, ", "))};
    }
    if (site.robots.empty()) return Error{"the site has no robot: add one under 'robots' with its shape and size"};
    if (std::holds_alternative<Mount>(camera->placement)) return prepare_onboard(site, *camera, arguments);
    if (!arguments.ranges.empty() || !arguments.landmark.empty()) {
        return Error{fmt::format("--ranges and --landmark go with a camera on a robot; {} is fixed in the map", camera->id)};
    }
    return prepare_fixed(site, *camera, arguments);
}

int fix_images(const Arguments& arguments) {
    const auto site = load_site(arguments.site);
    if (!site) {
        complain("the site file cannot be used:\n" + site.error().message);
        return bad_input;
    }
    auto shot = prepare(*site, arguments);
    if (!shot) {
        complain(shot.error().message);
        return bad_input;
    }
    int exit_code = done;
    const CameraModel& model = shot->model;
    for (const std::string& image : arguments.images) {
        const auto frame = load_luma(image);
        std::string problem;
        if (!frame) {
            problem = frame.error().message;
        } else if (frame->width() != model.width || frame->height() != model.height) {
            problem = fmt::format("{}: the picture is {} x {} pixels, camera {} has {} x {}: correct 'size' and 'intrinsics' in the site file", image,
                                  frame->width(), frame->height(), arguments.camera, model.width, model.height);
        }
        if (!problem.empty()) {
            complain(problem);
            fmt::print("{}\n", fix_line(empty_fix(image, problem)));
            exit_code = bad_input;
            continue;
        }
        for (const Fix& fix : shot->fixes(image, *frame)) fmt::print("{}\n", fix_line(fix));
        if (arguments.overlay.empty()) continue;
        std::error_code failure;
        std::filesystem::create_directories(arguments.overlay, failure);
        const auto file = std::filesystem::path(arguments.overlay) / (std::filesystem::path(image).stem().string() + ".png");
        if (auto saved = shot->overlay(file, *frame); !saved) {
            complain(saved.error().message);
            exit_code = bad_input;
        }
    }
    return exit_code;
}

}  // namespace

void add_fix(CLI::App& app, int& exit_code) {
    auto* command = app.add_subcommand("fix", "single pictures, no tracking: one JSON line per robot on stdout");
    auto arguments = std::make_shared<Arguments>();
    command->add_option("SITE", arguments->site, "site file")->required();
    command->add_option("--camera", arguments->camera, "which camera took the pictures")->required();
    command->add_option("IMAGE", arguments->images, "pictures")->required();
    command->add_option("--background", arguments->background, "pictures, folders or videos without robots");
    command->add_option("--method", arguments->method, "ours, or the paper's as published")->check(CLI::IsMember({"ours", "published"}))->capture_default_str();
    command->add_option("--ranges", arguments->ranges, "camera on a robot: ranges heard by the same robot, CSV, JSON lines or a Cricket listener's log");
    command->add_option("--landmark", arguments->landmark, "camera on a robot: which landmark is in view, where you know it");
    command->add_option("--overlay", arguments->overlay, "folder for pictures with the found robots drawn in");
    command->footer(
        "Example: roomfix simulate kim2011 -o /tmp/kim --duration 1 && roomfix fix /tmp/kim/site.yaml --camera up --ranges /tmp/kim/ranges.csv "
        "/tmp/kim/frames/up/*.jpg");
    command->callback([=, &exit_code] { exit_code = fix_images(*arguments); });
}

}  // namespace roomfix
