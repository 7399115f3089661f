#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "calibrate.hpp"
#include "commands.hpp"
#include "roomfix/connect/body_picture.hpp"
#include "roomfix/geometry/pose.hpp"
#include "roomfix/pipeline/robot_session.hpp"
#include "roomfix/site/body_parts.hpp"
#include "roomfix/site/load_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct RobotArguments {
    std::string session, robot, output, picture;
    double turn = 0;  // deg
    RobotSessionOptions options;
};

/// Turns the learned body about its middle, so that its front is where people say that it is.
void turn_body(LearnedBody& body, double angle) {
    const Eigen::AngleAxisd turn(angle, Eigen::Vector3d::UnitZ());
    for (ConvexPart& part : body.parts) {
        for (Eigen::Vector3d& p : part.points) p = turn * p;
    }
    const Eigen::Matrix3f rotation = turn.toRotationMatrix().cast<float>();
    for (LookSpot& spot : body.look.spots) {
        spot.place = rotation * spot.place;
        spot.outwards = rotation * spot.outwards;
    }
}

Result<const SiteRobot*> robot_of(const Site& site, const std::string& id) {
    std::string names;
    for (const SiteRobot& robot : site.robots) {
        if (robot.id == id || (id.empty() && site.robots.size() == 1)) return &robot;
        names += (names.empty() ? "" : ", ") + robot.id;
    }
    if (id.empty()) return Error{fmt::format("which robot? Give one by --robot: {}", names)};
    return Error{fmt::format("there is no robot '{}' in the site file; it has: {}", id, names)};
}

int calibrate_robot_command(RobotArguments arguments) {
    const std::filesystem::path file = site_file_of(arguments.session);
    const auto site = load_site(file);
    if (!site) return give_up(Error{"the site file cannot be used:\n" + site.error().message});
    const auto robot = robot_of(*site, arguments.robot);
    if (!robot) return give_up(robot.error());
    for (const std::string& camera : arguments.options.cameras) {
        if (site->camera(camera) == nullptr) return give_up(Error{fmt::format("there is no camera '{}' in {}", camera, file.string())});
    }
    if (!arguments.options.pictures.empty() && arguments.options.cameras.size() != 1) {
        return give_up(Error{"pictures are of one camera: name it by --camera"});
    }
    const std::filesystem::path output = arguments.output.empty() ? (*robot)->id + learned_body_ending : arguments.output;
    if (output.extension() != learned_body_ending)
        return give_up(Error{fmt::format("-o {}: a body file's name ends with {}", output.string(), learned_body_ending)});

    const auto session = RobotSession::collect(*site, arguments.options, stop_requested(), progress_bar("looking at the pictures"));
    if (!session) return give_up(session.error());
    auto lesson = learn_body(session->moments(), **robot, {}, progress_bar("learning the body"));
    if (!lesson) return give_up(Error{fmt::format("nothing was learned about {}: {}", (*robot)->id, lesson.error().message)});
    LearnedBody& body = lesson->body;
    turn_body(body, radians(arguments.turn));
    std::string cameras;
    for (const std::string& camera : session->cameras()) cameras += (cameras.empty() ? "" : ", ") + camera;
    body.learned_from = fmt::format("{} moments of camera {}", lesson->sights.size(), cameras);

    const Box box = box_around(body.parts);
    fmt::print("robot {}: seen at {} of {} moments ({} pictures)\n", (*robot)->id, lesson->sights.size(), session->moments().size(), session->frames());
    for (const std::size_t m : lesson->left_out) fmt::print("  not found in {}\n", session->names()[m]);
    fmt::print("  {:.3f} x {:.3f} x {:.3f} m, each side known to {:.3f} m; {} parts\n", box.length, box.width, box.height, body.size_sigma, body.parts.size());
    fmt::print("  its look: {} spots, {:.1f} nats each; {}\n", body.look.spots.size(), lesson->per_spot,
               body.symmetry == 0 ? "it has no direction" : "it tells the front from the back: look at the picture, and turn it by --turn 180 if need be");
    for (const BodySight& sight : lesson->sights) {
        fmt::print("  {}: x {:.3f}, y {:.3f}{}\n", session->names()[sight.moment], sight.pose.x, sight.pose.y,
                   body.symmetry == 0 ? "" : fmt::format(", yaw {:.1f} deg", degrees(wrap_angle(sight.pose.yaw - radians(arguments.turn)))));
    }
    if (!write_file(output, learned_body_text(body))) return bad_input;
    const std::filesystem::path picture =
        arguments.picture.empty() ? std::filesystem::path(output).replace_extension(".png") : std::filesystem::path(arguments.picture);
    if (auto saved = save_body_picture(picture, body); !saved) return give_up(saved.error());
    say(fmt::format("written: {} and a picture of it, {}; put it into the site file: {}: {{model: {}}}", output.string(), picture.string(), (*robot)->id,
                    output.filename().string()));
    return done;
}

}  // namespace

void add_calibrate_robot(Command& calibrate) {
    Command robot = calibrate.add_command("robot", "what a robot looks like, from pictures of fixed cameras in which it stands at different places");
    auto arguments = std::make_shared<RobotArguments>();
    robot.option("SITE", arguments->session, "site file, or session folder; the robot's entry has its rough shape and size").required();
    robot.option("PICTURES", arguments->options.pictures, "of the camera, each a moment (default: what the cameras' sources have recorded)");
    robot.option("--robot", arguments->robot, "which robot (default: the only one)");
    robot.repeatable("--camera", arguments->options.cameras, "only this one is used (default: all fixed ones)");
    robot.repeatable("--background", arguments->options.background,
                     "pictures without the robot (default: as in the site file, or what is usual in the pictures themselves)");
    robot.option("--turn", arguments->turn, "degrees by which to turn the learned body, so that its front points along x").range(-360.0, 360.0);
    robot.option("-o,--output", arguments->output, "body file (default: ROBOT.body); a picture of it is written beside it");
    robot.option("--picture", arguments->picture, "where to write the picture of the body");
    robot.footer(
        "Three stops are the least, ten at different places and headings are good; other things may lie around.\n"
        "Example: roomfix calibrate robot hall.yaml --robot cart --camera north --background empty/ stops/*.jpg -o cart.body");
    robot.on_run([=] { return calibrate_robot_command(*arguments); });
}

}  // namespace roomfix
