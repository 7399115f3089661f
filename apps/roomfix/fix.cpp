#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "roomfix/connect/fix_json.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/pipeline/single_shot.hpp"
#include "roomfix/site/load_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string site;
    std::string camera;
    std::vector<std::string> images;
    std::string method = "ours";
    std::string overlay;
    std::optional<double> heading_deg;
    ShotOptions options;
};

int fix_images(const Arguments& arguments) {
    const auto site = load_site(arguments.site);
    if (!site) {
        complain("the site file cannot be used:\n" + site.error().message);
        return bad_input;
    }
    const SiteCamera* camera = site->camera(arguments.camera);
    if (!camera) {
        std::vector<std::string> ids;
        for (const auto& c : site->cameras) ids.push_back(c.id);
        complain(fmt::format("there is no camera '{}' in {}: it has {}", arguments.camera, arguments.site, fmt::join(ids, ", ")));
        return bad_input;
    }
    ShotOptions options = arguments.options;
    options.images = arguments.images;
    options.published = arguments.method == "published";
    if (arguments.heading_deg) options.heading = radians(*arguments.heading_deg);
    options.note = say;
    auto shot = prepare_shot(*site, *camera, options);
    if (!shot) {
        complain(shot.error().message);
        return bad_input;
    }
    int exit_code = done;
    const CameraModel& model = shot->model;
    for (const std::string& image : arguments.images) {
        LumaImage frame;
        ColourImage colour;
        std::vector<std::uint8_t> buffer;
        const auto loaded = load_picture(image, frame, colour, buffer);
        std::string problem;
        if (!loaded) {
            problem = loaded.error().message;
        } else if (frame.width() != model.width || frame.height() != model.height) {
            problem = fmt::format("{}: the picture is {} x {} pixels, camera {} has {} x {}: correct 'size' and 'intrinsics' in the site file", image,
                                  frame.width(), frame.height(), arguments.camera, model.width, model.height);
        }
        if (!problem.empty()) {
            complain(problem);
            fmt::print("{}\n", fix_line(empty_fix(image, problem)));
            exit_code = bad_input;
            continue;
        }
        for (const Fix& fix : shot->fixes(image, {frame, &colour})) fmt::print("{}\n", fix_line(fix));
        if (arguments.overlay.empty()) continue;
        std::error_code failure;
        std::filesystem::create_directories(arguments.overlay, failure);
        const auto file = std::filesystem::path(arguments.overlay) / (std::filesystem::path(image).stem().string() + ".png");
        if (auto saved = shot->overlay(file, frame); !saved) {
            complain(saved.error().message);
            exit_code = bad_input;
        }
    }
    return exit_code;
}

}  // namespace

void add_fix(Command& program) {
    Command command = program.add_command("fix", "single pictures, no tracking: one JSON line per robot on stdout");
    auto arguments = std::make_shared<Arguments>();
    command.option("SITE", arguments->site, "site file").required();
    command.option("--camera", arguments->camera, "which camera took the pictures").required();
    command.option("IMAGE", arguments->images, "pictures").required();
    command.repeatable("--background", arguments->options.background, "picture, folder or video without robots");
    command.option("--method", arguments->method, "ours, or the paper's as published").one_of({"ours", "published"}).show_default();
    command.option("--ranges", arguments->options.ranges, "camera on a robot: ranges heard by the same robot, CSV, JSON lines or a Cricket listener's log");
    command.option("--landmark", arguments->options.landmark, "camera on a robot: which landmark is in view, where you know it");
    command.option("--corner", arguments->options.corner, "camera that looks for corners: which one is in view, where you know it");
    command.option("--heading-deg", arguments->heading_deg, "camera that looks for corners: where it looks, roughly, counter-clockwise from the map's x axis")
        .range(-360.0, 360.0);
    command.option("--overlay", arguments->overlay, "folder for pictures with the found robots drawn in");
    command.footer(
        "Example: roomfix simulate kim2011 -o /tmp/kim --duration 1 && roomfix fix /tmp/kim/site.yaml --camera up --ranges /tmp/kim/ranges.csv "
        "/tmp/kim/frames/up/*.jpg");
    command.on_run([=] { return fix_images(*arguments); });
}

}  // namespace roomfix
