#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/connect/camera_probe.hpp"
#include "roomfix/connect/shown_address.hpp"
#include "roomfix/pipeline/first_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string file = "site.yaml";
    std::vector<std::string> cameras;
};

/// What somebody types after a question; what is offered where nothing is typed, or nobody is there.
std::string ask(const std::string& question, const std::string& offered) {
    fmt::print(stderr, "{} [{}]: ", question, offered);
    std::string answer;
    if (!std::getline(std::cin, answer)) fmt::print(stderr, "\n");
    while (!answer.empty() && (answer.back() == '\r' || answer.back() == ' ')) answer.pop_back();
    return answer.empty() ? offered : answer;
}

/// Positive numbers between commas; asks again as long as it is something else and somebody is there.
std::vector<double> ask_numbers(const std::string& question, const std::string& offered, std::size_t count) {
    while (true) {
        const auto numbers = parse_numbers(ask(question, offered));
        if (numbers && numbers->size() == count && std::all_of(numbers->begin(), numbers->end(), [](double n) { return n > 0 && n < 1000; })) return *numbers;
        if (!std::cin) return *parse_numbers(offered);
        say(count == 1 ? "a number in metres, please" : fmt::format("{} numbers in metres with commas between them, please", count));
    }
}

bool yes(const std::string& question) { return ask(question, "yes").starts_with('y'); }

/// Looks through a camera; nothing, with a complaint, if it gives no picture.
std::optional<FirstCamera> camera_of(const std::string& source, std::size_t number) {
    const auto picture = first_picture(source);
    if (!picture) {
        complain(picture.error().message);
        return std::nullopt;
    }
    say(fmt::format("{}: {} x {}", shown_address(source), picture->image.width(), picture->image.height()));
    return FirstCamera{fmt::format("cam{}", number), source, picture->image.width(), picture->image.height()};
}

/// Those that were named, or those of this machine that somebody wants. By a name that stays the same, where there is one.
std::vector<FirstCamera> find_cameras(const std::vector<std::string>& named) {
    std::vector<std::string> sources = named;
    if (named.empty()) {
        for (const VideoDeviceInfo& device : list_video_devices()) {
            if (device.problem.empty() && yes(fmt::format("use the camera {} ({})", device.card, device.path))) {
                sources.push_back(device.links.empty() ? device.path : device.links.front());
            }
        }
    }
    std::vector<FirstCamera> cameras;
    for (const std::string& source : sources) {
        if (auto camera = camera_of(source, cameras.size() + 1)) cameras.push_back(std::move(*camera));
    }
    if (cameras.empty()) say("no camera yet: add them under 'cameras' (docs/guide.md, examples/one-camera/site.yaml)");
    return cameras;
}

int init(const Arguments& arguments) {
    if (std::filesystem::exists(arguments.file)) {
        complain(fmt::format("{} is there already, and nothing is overwritten: name another file with -o", arguments.file));
        return bad_input;
    }
    FirstSite site;
    site.name = ask("name of the place (letters, digits, - and _)", "hall");
    for (char& c : site.name) {
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_') c = '_';
    }
    site.ceiling = ask_numbers("height of the ceiling, m", "3", 1).front();
    site.cameras = find_cameras(arguments.cameras);
    const bool round = ask("shape of the robot, box or cylinder", "box").starts_with('c');
    site.robots.push_back(
        {"r1", round, round ? ask_numbers("its diameter and height, m", "0.4, 0.5", 2) : ask_numbers("its length, width and height, m", "0.6, 0.5, 0.4", 3)});
    if (!write_file(arguments.file, first_site_text(site))) return failed;
    say(fmt::format("{} is written. Next: where do the cameras hang? See the comments in it, then: roomfix check {}", arguments.file, arguments.file));
    return done;
}

}  // namespace

void add_init(Command& program) {
    Command command = program.add_command("init", "asks a few questions, looks through the cameras and writes a first site file");
    auto arguments = std::make_shared<Arguments>();
    command.option("CAMERA", arguments->cameras, "cameras: devices, addresses (rtsp://..., http://...) or recordings (default: asks for each of this machine)");
    command.option("-o,--output", arguments->file, "site file to write").show_default();
    command.footer("Example: roomfix init -o site.yaml rtsp://192.168.1.20/stream1");
    command.on_run([=] { return init(*arguments); });
}

}  // namespace roomfix
