#include "roomfix/overhead/edge_profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "roomfix/overhead/outline_fit.hpp"

namespace roomfix {
namespace {

constexpr int longest_reach = 24;
constexpr float darkest_background = 6;  // grey levels: below, the ratio says nothing
constexpr float lit_tolerance = 0.04f;
constexpr float darkest_shadow = 0.40f;   // in grey levels, i.e. after gamma
constexpr float background_step = 0.15f;  // part of the light: a step in the empty room that may be something's border

/// frame / (gain * background) along the profile; index 0 is the outermost.
struct Profile {
    std::array<float, 2 * longest_reach + 1> ratio;
    std::array<float, 2 * longest_reach + 1> grey;   // the frame alone, relative to the background at the outline
    std::array<float, 2 * longest_reach + 1> floor;  // the background alone, likewise
    int count = 0;
    int centre = 0;       // index of the predicted outline
    float noise = 0.02f;  // standard deviation of one value
};

Profile read_profile(const FrameEvidence& evidence, const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal, int reach) {
    Profile profile;
    const BackgroundModel& background = *evidence.background;
    const LumaView mean = background.mean();
    const float width = static_cast<float>(evidence.frame.width - 2);
    const float height = static_cast<float>(evidence.frame.height - 2);
    const float gain = background.gain_at(*evidence.foreground, static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
    const float middle = std::max(sample(mean, static_cast<float>(pixel.x()), static_cast<float>(pixel.y())) * gain, darkest_background);
    const float px = static_cast<float>(pixel.x());
    const float py = static_cast<float>(pixel.y());
    const float nx = static_cast<float>(normal.x());
    const float ny = static_cast<float>(normal.y());
    for (int s = reach; s >= -reach; --s) {
        const float x = px + static_cast<float>(s) * nx;
        const float y = py + static_cast<float>(s) * ny;
        if (x < 0 || y < 0 || x >= width || y >= height) {
            if (profile.count > 0) break;  // left the image on the inner side
            continue;
        }
        if (profile.count == 0) profile.centre = s;
        const float floor = std::max(sample(mean, x, y) * gain, darkest_background);
        const float grey = sample(evidence.frame, x, y);
        profile.ratio[static_cast<std::size_t>(profile.count)] = grey / floor;
        profile.floor[static_cast<std::size_t>(profile.count)] = floor / middle;
        profile.grey[static_cast<std::size_t>(profile.count++)] = grey / middle;
    }
    const int column = static_cast<int>(pixel.x());
    const int line = static_cast<int>(pixel.y());
    const float deviation = static_cast<float>(background.limit().at(column, line) - background.settings().limit_floor) / 5.0f;
    profile.noise = std::max(deviation, 0.7f) / std::max(mean.at(column, line) * gain, darkest_background);
    return profile;
}

}  // namespace

EdgeReading read_edge(const FrameEvidence& evidence, const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal, int reach) {
    EdgeReading reading;
    const Profile profile = read_profile(evidence, pixel, normal, std::min(reach, longest_reach));
    const auto bit = [&](const BitMask& mask, double s) {
        const Eigen::Vector2d p = pixel + s * normal;
        return mask.at(static_cast<int>(std::lround(std::clamp(p.x(), 0.0, evidence.frame.width - 1.0))),
                       static_cast<int>(std::lround(std::clamp(p.y(), 0.0, evidence.frame.height - 1.0))));
    };
    reading.inside_foreground = bit(*evidence.mask, -3);
    // The robot's own shadow beside it does not say that the robot goes on there.
    reading.outside_foreground = bit(*evidence.mask, 3) && !bit(evidence.foreground->shadow, 3);

    const auto r = [&](int j) { return profile.ratio[static_cast<std::size_t>(j)]; };
    const auto level_outside = [&](int j) { return 0.5f * (r(j - 2) + r(std::max(j - 3, 0))); };
    const auto contrast = [&](int j) { return level_outside(j) - 0.5f * (r(j + 2) + r(std::min(j + 3, profile.count - 1))); };
    const float threshold = std::max(0.06f, 4 * profile.noise);
    double best = 1e9;
    for (int j = 2; j + 2 < profile.count; ++j) {
        const float c = contrast(j);
        const float size = std::abs(c);
        if (size < threshold) continue;
        // The largest step around: not the flank of a larger one.
        if (j > 2 && std::abs(contrast(j - 1)) > size) continue;
        if (j + 3 < profile.count && std::abs(contrast(j + 1)) >= size) continue;
        // A step of the ratio without one in the frame is the background's own: something as grey as what it covers.
        const auto step = [&](const auto& values) {
            const auto at = [&](int i) { return values[static_cast<std::size_t>(std::clamp(i, 0, profile.count - 1))]; };
            return 0.5f * std::abs(at(j - 2) + at(j - 3) - at(j + 2) - at(j + 3));
        };
        if (2 * step(profile.grey) < size) continue;
        const float outside = level_outside(j);
        const bool lit = std::abs(outside - 1) < std::max(lit_tolerance, 3 * profile.noise);
        const auto like_shadow = [&](float level, int near, int far) {
            const bool flat = std::abs(r(near) - r(far)) < std::max(0.05f, 4 * profile.noise);
            return flat && level > darkest_shadow && level < 1;
        };
        const bool shadowed = !lit && like_shadow(outside, j - 2, std::max(j - 4, 0));
        if (!lit && !shadowed) continue;
        // Subpixel: where the profile crosses half way between both levels.
        const float half = outside - 0.5f * c;
        for (int k = j - 2; k < j + 2; ++k) {
            const float a = r(k) - half;
            const float b = r(k + 1) - half;
            if ((a > 0) == (b > 0) || a == b) continue;
            const double offset = profile.centre - (k + static_cast<double>(a / (a - b)));
            const double cost = std::abs(offset) + (shadowed ? 0.5 : 0);
            if (cost < best) {
                best = cost;
                reading.found = true;
                reading.offset = offset;
                reading.shadowed = shadowed;
                reading.into_shadow = lit && like_shadow(outside - c, j + 2, std::min(j + 4, profile.count - 1));
                reading.on_background_edge = step(profile.floor) > background_step;
                reading.contrast = static_cast<double>(size);
                reading.sigma = static_cast<double>(profile.noise / std::max(std::abs(a - b), 0.5f * threshold));
            }
        }
    }
    return reading;
}

}  // namespace roomfix
