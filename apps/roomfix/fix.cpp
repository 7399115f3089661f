#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/connect/fix_json.hpp"
#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/overlay.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/overhead/li2014.hpp"
#include "roomfix/overhead/overhead_observer.hpp"
#include "roomfix/pipeline/background_source.hpp"
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
        std::vector<Fix> fixes;
        for (const SilhouetteObservation& o : result_.observations) {
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

Result<SingleShot> prepare(const Site& site, const Arguments& arguments) {
    const SiteCamera* camera = site.camera(arguments.camera);
    if (!camera) {
        std::vector<std::string> ids;
        for (const auto& c : site.cameras) ids.push_back(c.id);
        return Error{fmt::format("there is no camera '{}' in {}: it has {}", arguments.camera, arguments.site, fmt::join(ids, ", "))};
    }
    if (site.robots.empty()) return Error{"the site has no robot: add one under 'robots' with its shape and size"};
    const auto view = fixed_view(*camera);
    if (!view) return view.error();
    const auto sources = background_sources(site, *camera, arguments);
    if (sources.empty()) {
        return Error{
            fmt::format("camera {} has no background to compare with: give pictures without robots by --background, or 'background' in the site "
                        "file (or {} pictures or more at once)",
                        camera->id, enough_to_learn)};
    }
    auto background = learn_background(*camera, sources);
    if (!background) return background.error();
    SingleShot shot(site, *camera, *view, std::move(*background));
    if (arguments.method == "published") {
        const auto frames = load_frames(sources);
        if (!frames) return frames.error();
        if (auto used = shot.use_published(*frames); !used) return used.error();
    }
    return shot;
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
    const CameraModel& model = shot->view().model;
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
        std::vector<std::string> labels;
        for (const auto& o : shot->result().observations) {
            labels.push_back(fmt::format("{} ({:.2f}, {:.2f})", site->robots[static_cast<std::size_t>(o.robot)].id, o.pose.x, o.pose.y));
        }
        const auto file = std::filesystem::path(arguments.overlay) / (std::filesystem::path(image).stem().string() + ".png");
        if (auto saved = save_overlay(file, *frame, shot->view(), shot->result().observations, labels); !saved) {
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
    command->add_option("--overlay", arguments->overlay, "folder for pictures with the found robots drawn in");
    command->footer("Example: roomfix fix examples/hall/site.yaml --camera hall examples/hall/frames/hall/000000000000.jpg");
    command->callback([=, &exit_code] { exit_code = fix_images(*arguments); });
}

}  // namespace roomfix
