#include "roomfix/connect/camera_probe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>

#include "roomfix/connect/shown_address.hpp"
#include "roomfix/imaging/load_luma.hpp"

namespace roomfix {
namespace {

constexpr int least_pictures = 30;
constexpr int first_counted = 5;     // those before may have waited for us
constexpr double known_time = 0.01;  // s, 1 sigma
constexpr double longest = 6;        // s: a camera that tells the time does so within about 5

/// "30/s"; nothing where the camera does not say.
std::string rate_text(double rate) { return rate > 0 ? fmt::format(" {:.3g}/s", rate) : ""; }

/// An error that names the camera, once.
Error about(const std::string& source, const Error& error) {
    const std::string name = shown_address(source);
    return error.message.starts_with(name) ? error : Error{name + ": " + error.message};
}

}  // namespace

Result<CameraProbe> probe_camera(const std::string& source) {
    auto opened = open_source(source);
    if (!opened) return about(source, opened.error());
    FrameSource& camera = **opened;
    if (!camera.live()) return Error{fmt::format("{}: a recording and no camera: name a device or an address", source)};
    CameraProbe probe;
    const auto now = std::chrono::steady_clock::now;
    const auto opened_at = now();
    auto first = opened_at;
    std::int64_t before = 0;  // pictures until then
    for (int count = 1;; ++count) {
        const auto more = camera.advance(probe.picture);
        if (!more) return about(source, more.error());
        if (!*more) return Error{fmt::format("{}: the camera ended its stream", shown_address(source))};
        const std::int64_t came = count + camera.passed_over();
        if (count == first_counted) {
            first = now();
            before = came;
        }
        const double seconds = std::chrono::duration<double>(now() - first).count();
        if (count > first_counted) probe.rate = static_cast<double>(came - before) / seconds;
        if (count >= least_pictures && probe.picture.time_error.sigma < known_time) break;
        if (std::chrono::duration<double>(now() - opened_at).count() > longest) break;
    }
    if (auto decoded = camera.decode(probe.picture); !decoded) return about(source, decoded.error());
    probe.note = camera.note();
    return probe;
}

Result<SourceFrame> first_picture(const std::string& source) {
    auto opened = open_source(source);
    if (!opened) return about(source, opened.error());
    SourceFrame frame;
    const auto more = (*opened)->next(frame);
    if (!more) return about(source, more.error());
    if (!*more) return Error{fmt::format("{}: there is no picture in it", shown_address(source))};
    return frame;
}

std::string description_of(const VideoDeviceInfo& camera) {
    std::string text = camera.path;
    if (!camera.card.empty()) text += fmt::format("  {} ({})", camera.card, camera.bus);
    if (!camera.serial.empty()) text += ", serial number " + camera.serial;
    text += '\n';
    if (!camera.links.empty()) text += fmt::format("    always found as  source: {}\n", camera.links.front());
    for (std::size_t i = 1; i < camera.links.size(); ++i) text += fmt::format("                 or  source: {}\n", camera.links[i]);
    for (std::size_t i = 0; i < camera.modes.size();) {
        const VideoMode& size = camera.modes[i];
        text += fmt::format("    {} x {} ", size.width, size.height);
        for (bool more = false; i < camera.modes.size() && camera.modes[i].width == size.width && camera.modes[i].height == size.height; ++i, more = true) {
            text += fmt::format("{} {}{}", more ? "," : "", name_of(camera.modes[i].format), rate_text(camera.modes[i].rate));
        }
        text += '\n';
    }
    if (!camera.problem.empty()) text += "    " + camera.problem + '\n';
    return text;
}

std::string description_of(const std::string& source, const CameraProbe& camera) {
    const char* format = camera.picture.encoded.empty() ? "" : ", JPEG";
    return fmt::format("{}\n    {} x {}{},{}\n    {}\n", shown_address(source), camera.picture.image.width(), camera.picture.image.height(), format,
                       camera.rate > 0 ? rate_text(camera.rate) : " one picture", camera.note);
}

Result<void> save_picture(const std::string& file, const SourceFrame& picture) {
    if (picture.encoded.empty() || !(file.ends_with(".jpg") || file.ends_with(".jpeg"))) return save_luma(file, picture.image);
    std::ofstream stream(file, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(picture.encoded.data()), static_cast<std::streamsize>(picture.encoded.size()));
    stream.close();
    if (!stream) return Error{fmt::format("{}: cannot be written: check that the folder exists and has room", file)};
    return {};
}

}  // namespace roomfix
