#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "roomfix/connect/camera_probe.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::vector<std::string> sources;
    std::string picture;
};

/// The cameras of this machine; those that can be opened become sources to look at.
int list_devices(std::vector<std::string>& sources) {
    const std::vector<VideoDeviceInfo> devices = list_video_devices();
    for (const VideoDeviceInfo& device : devices) {
        fmt::print("{}", description_of(device));
        if (device.problem.empty()) sources.push_back(device.path);
    }
    if (!devices.empty()) return done;
    complain(
        "this machine has no camera: plug one in; a container or a virtual machine must be given it (podman run --device /dev/video0 ...). Cameras on the "
        "network are looked at by their addresses: roomfix cameras rtsp://user:password@192.168.1.20/stream1");
    return failed;
}

/// Looks through each camera and describes it.
int look(const std::vector<std::string>& sources, const std::string& picture, bool describe) {
    int exit_code = done;
    bool saved = picture.empty();
    for (const std::string& source : sources) {
        const auto probe = probe_camera(source);
        if (!probe) {
            complain(probe.error().message);
            exit_code = failed;
            continue;
        }
        if (describe) fmt::print("{}", description_of(source, *probe));
        if (saved) continue;
        if (const auto written = save_picture(picture, probe->picture); !written) {
            complain(written.error().message);
            return failed;
        }
        say(fmt::format("{}: what the camera sees", picture));
        saved = true;
    }
    return saved ? exit_code : failed;
}

int cameras(Arguments arguments) {
    if (!arguments.sources.empty()) return look(arguments.sources, arguments.picture, true);
    const int listed = list_devices(arguments.sources);
    if (listed != done || arguments.picture.empty()) return listed;
    return look(arguments.sources, arguments.picture, false);
}

}  // namespace

void add_cameras(Command& program) {
    Command command = program.add_command("cameras", "lists the cameras of this machine and looks at those on the network");
    auto arguments = std::make_shared<Arguments>();
    command.option("CAMERA", arguments->sources, "cameras to look at: addresses (rtsp://..., http://...) or devices (default: lists this machine's)");
    command.option("--picture", arguments->picture, "file (.jpg, .png) for a picture of the first camera that gives one");
    command.footer("Example: roomfix cameras --picture test.png");
    command.on_run([=] { return cameras(*arguments); });
}

}  // namespace roomfix
