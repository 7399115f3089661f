// Exposure, gain and white balance of a V4L2 camera, and the times of its buffers.
#include <fmt/format.h>
#include <linux/videodev2.h>

#include <cmath>
#include <vector>

#include "roomfix/connect/v4l2_camera.hpp"

namespace roomfix {
namespace {

constexpr double exposure_unit = 1e-4;  // s, of V4L2_CID_EXPOSURE_ABSOLUTE
constexpr double clock_sigma = 0.001;   // s: of a buffer's time stamp
constexpr double oldest = 1;            // s: a stamp that is older, or lies ahead, is not of this clock
constexpr double arrival_sigma = 0.03;  // s

bool set(VideoDevice& device, std::uint32_t id, std::int32_t value) {
    v4l2_control control{id, value};
    return device.control(VIDIOC_S_CTRL, &control) == 0;
}

std::optional<std::int32_t> value_of(VideoDevice& device, std::uint32_t id) {
    v4l2_control control{id, 0};
    if (device.control(VIDIOC_G_CTRL, &control) != 0) return std::nullopt;
    return control.value;
}

/// One thing that a camera either sets by itself or keeps as it is told.
struct Knob {
    const char* name;  // in the site file
    std::uint32_t automatic;
    std::int32_t off, on;  // of `automatic`
    std::uint32_t value;
    double unit;
};

/// The value that holds from now on; nothing where the camera sets it by itself or has no such thing.
std::optional<double> turn(VideoDevice& device, const Knob& knob, const std::optional<double>& wanted, std::vector<std::string>& told) {
    if (!wanted) {
        const auto automatic = value_of(device, knob.automatic);
        if (automatic && *automatic != knob.off) {
            told.push_back(fmt::format("the camera sets its {} by itself: fix it with capture: {{{}: ...}}", knob.name, knob.name));
            return std::nullopt;
        }
    } else {
        (void)set(device, knob.automatic, knob.off);  // not all cameras have it
        if (!set(device, knob.value, static_cast<std::int32_t>(std::lround(*wanted / knob.unit)))) {
            told.push_back(fmt::format("the camera does not take {} = {}", knob.name, *wanted));
        }
    }
    const auto held = value_of(device, knob.value);
    if (!held) return std::nullopt;
    const double value = *held * knob.unit;
    if (wanted && std::abs(value - *wanted) > 0.5 * knob.unit + 1e-9) told.push_back(fmt::format("{} is {} and not {}", knob.name, value, *wanted));
    return value;
}

}  // namespace

AppliedSettings apply_settings(VideoDevice& device, const CaptureSettings& wanted) {
    constexpr Knob exposure{"exposure",   V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_APERTURE_PRIORITY, V4L2_CID_EXPOSURE_ABSOLUTE,
                            exposure_unit};
    constexpr Knob gain{"gain", V4L2_CID_AUTOGAIN, 0, 1, V4L2_CID_GAIN, 1};
    constexpr Knob white{"white_balance", V4L2_CID_AUTO_WHITE_BALANCE, 0, 1, V4L2_CID_WHITE_BALANCE_TEMPERATURE, 1};
    std::vector<std::string> told;
    AppliedSettings applied;
    if (wanted.rate) (void)set(device, V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0);  // long exposures in the dark must not slow it down; not all have it
    applied.exposure = turn(device, exposure, wanted.exposure, told);
    (void)turn(device, gain, wanted.gain, told);
    (void)turn(device, white, wanted.white_balance, told);
    applied.told = fmt::format("{}", fmt::join(told, "; "));
    return applied;
}

StampedTime middle_of_exposure(const BufferStamp& stamp, const ClockPair& now, std::optional<double> exposure, double interval, double readout) {
    const double age = now.monotonic - stamp.seconds;
    if (!stamp.monotonic || age < -clock_sigma || age > oldest) return {now.system, {arrival_sigma}};
    // What nobody states lies anywhere from nothing to a whole interval.
    constexpr double spread = 0.289;  // of an interval, 1 sigma of what lies evenly within it
    const double half = 0.5 * exposure.value_or(0.5 * interval);
    const double half_sigma = exposure ? 0 : 0.5 * spread * interval;
    if (stamp.start_of_exposure) return {now.system + from_seconds(half + 0.5 * readout - age), {std::hypot(clock_sigma, half_sigma)}};
    // Read out is it once its last row is.
    const double since_middle_row = readout > 0 ? 0.5 * readout : 0.5 * interval;
    const double readout_sigma = readout > 0 ? 0 : spread * interval;
    return {now.system + from_seconds(-half - since_middle_row - age), {std::hypot(clock_sigma, half_sigma, readout_sigma)}};
}

}  // namespace roomfix
