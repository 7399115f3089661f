// Finds robots in single pictures of one camera: find_robots SITE.yaml CAMERA PICTURE...
#include <fmt/format.h>

#include <cmath>
#include <roomfix/imaging/load_luma.hpp>
#include <roomfix/pipeline/single_shot.hpp>
#include <roomfix/site/load_site.hpp>
#include <string>
#include <vector>

int main(int count, char** arguments) {
    if (count < 4) {
        fmt::print(stderr, "usage: find_robots SITE.yaml CAMERA PICTURE...\n");
        return 2;
    }
    const auto give_up = [](const roomfix::Error& error) {
        fmt::print(stderr, "{}\n", error.message);
        return 1;
    };
    const auto site = roomfix::load_session(arguments[1]);
    if (!site) return give_up(site.error());
    const roomfix::SiteCamera* camera = site->camera(arguments[2]);
    if (camera == nullptr) return give_up({fmt::format("there is no camera '{}' in the site", arguments[2])});

    roomfix::ShotOptions options;
    options.images.assign(arguments + 3, arguments + count);
    const auto shot = roomfix::prepare_shot(*site, *camera, options);
    if (!shot) return give_up(shot.error());
    for (const std::string& picture : options.images) {
        const auto frame = roomfix::load_luma(picture);
        if (!frame) return give_up(frame.error());
        for (const roomfix::Fix& fix : shot->fixes(picture, {*frame, nullptr})) {
            if (fix.status == roomfix::FixStatus::none) {
                fmt::print("{}: none: {}\n", picture, fix.reason);
            } else {
                fmt::print("{}: {} at {:.3f} {:.3f} m, {:.1f} deg, one sigma {:.1f} {:.1f} mm\n", picture, fix.robot, fix.pose.x, fix.pose.y,
                           roomfix::degrees(fix.pose.yaw), 1e3 * std::sqrt(fix.covariance(0, 0)), 1e3 * std::sqrt(fix.covariance(1, 1)));
            }
        }
    }
}
