#include "roomfix/overhead/look_score.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace roomfix {
namespace {

constexpr double log_two_pi = 1.8378770664093453;

const float* colour_of(const Evidence& evidence, std::size_t pixel) { return evidence.colours.data() + pixel * static_cast<std::size_t>(evidence.channels); }

/// A look in colour is compared with a grey picture in grey, and the other way round.
double channel_of(const float* colour, int channels, int wanted, int k) {
    if (channels == wanted) return static_cast<double>(colour[k]);
    return static_cast<double>(channels == 1 ? colour[0] : (colour[0] + colour[1] + colour[2]) / 3);
}

/// A histogram's median: levels beyond it are no light.
struct MedianOfOffs {
    static constexpr int bins = 81;
    static constexpr double width = 0.025;
    std::array<int, bins> counts{};
    int count = 0;

    void add(double off) {
        ++counts[static_cast<std::size_t>(std::clamp(static_cast<int>(std::lround(off / width)) + bins / 2, 0, bins - 1))];
        ++count;
    }
    double median() const {
        int below = 0;
        for (int i = 0; i < bins; ++i) {
            below += counts[static_cast<std::size_t>(i)];
            if (2 * below >= count) return width * (i - bins / 2);
        }
        return 0;
    }
};

}  // namespace

int see_spots(const View& view, const Evidence& evidence, const BodyLook& look, const Pose2& pose, const LookSettings& settings, std::vector<SeenSpot>& seen,
              std::size_t step) {
    seen.clear();
    int facing = 0;
    const Eigen::Matrix3d map_from_robot = Eigen::AngleAxisd(pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Vector3d origin(pose.x, pose.y, 0);
    const Eigen::Matrix3d camera_from_map = view.map_from_camera.pose.linear().transpose();
    const Eigen::Matrix3d camera_from_robot = camera_from_map * map_from_robot;
    const Eigen::Vector3d origin_in_camera = camera_from_map * (origin - view.position());
    const Eigen::Vector3d eye = map_from_robot.transpose() * (view.position() - origin);
    const double shrink = 1.0 / evidence.scale;
    for (std::size_t i = 0; i < look.spots.size(); i += step) {
        const Eigen::Vector3d place = look.spots[i].place.cast<double>();
        const Eigen::Vector3d to_eye = eye - place;
        const double across = to_eye.dot(look.spots[i].outwards.cast<double>());
        if (across <= 0 || across * across < settings.facing * settings.facing * to_eye.squaredNorm()) continue;
        ++facing;
        const auto pixel = project(view.model, camera_from_robot * place + origin_in_camera);
        if (!pixel) continue;
        const double x = (pixel->x() + 0.5) * shrink;
        const double y = (pixel->y() + 0.5) * shrink;
        if (!(x >= 0 && y >= 0 && x < evidence.width && y < evidence.height)) continue;
        seen.push_back({i, static_cast<std::size_t>(y) * static_cast<std::size_t>(evidence.width) + static_cast<std::size_t>(x)});
    }
    return facing;
}

ToneChange tone_on(const Evidence& evidence, const BodyLook& look, const std::vector<SeenSpot>& seen, const LookSettings& settings) {
    const auto for_each_colour = [&](auto&& visit) {
        for (const SeenSpot& s : seen) {
            for (int k = 0; k < look.channels; ++k) {
                const auto looks = static_cast<double>(look.spots[s.spot].colour[static_cast<std::size_t>(k)]);
                visit(looks, channel_of(colour_of(evidence, s.pixel), evidence.channels, look.channels, k) - looks);
            }
        }
    };
    double sum = 0;
    for_each_colour([&](double looks, double) { sum += looks; });
    const double mean = sum / std::max(1.0, static_cast<double>(seen.size()) * look.channels);
    // Dark and bright colours apart.
    struct Half {
        double colours = 0;
        MedianOfOffs offs;
    } dark, bright;
    for_each_colour([&](double looks, double off) {
        Half& half = looks < mean ? dark : bright;
        half.colours += looks;
        half.offs.add(off);
    });
    ToneChange tone;
    tone.middle = mean;
    if (dark.offs.count > 0 && bright.offs.count > 0) {
        constexpr double noise = 0.1;  // of the difference of two medians
        const double apart = bright.colours / bright.offs.count - dark.colours / dark.offs.count;
        const double variance = settings.contrast_sigma * settings.contrast_sigma;
        tone.contrast = (bright.offs.median() - dark.offs.median()) * apart * variance / (apart * apart * variance + noise * noise);
        tone.contrast = std::clamp(tone.contrast, -2 * settings.contrast_sigma, 2 * settings.contrast_sigma);
    }
    MedianOfOffs offs;
    for_each_colour([&](double looks, double off) { offs.add(off - tone.of(looks)); });
    tone.light = offs.median();
    return tone;
}

LookScore score_look(const View& view, const Evidence& evidence, const BodyLook& look, const Pose2& pose, double clutter, const LookSettings& settings,
                     std::vector<SeenSpot>& seen, std::size_t step) {
    LookScore score;
    score.spots = see_spots(view, evidence, look, pose, settings, seen, step);
    score.seen = static_cast<int>(seen.size());
    if (score.seen < settings.least_spots) return score;
    ToneChange tone = tone_on(evidence, look, seen, settings);
    tone.light = std::clamp(tone.light, -2 * settings.light_sigma, 2 * settings.light_sigma);
    const double log_range = std::log(evidence.colour_range);
    double sum = 0;
    for (const SeenSpot& s : seen) {
        const LookSpot& spot = look.spots[s.spot];
        const float* colour = colour_of(evidence, s.pixel);
        double squares = 0;
        for (int k = 0; k < look.channels; ++k) {
            const auto looks = static_cast<double>(spot.colour[static_cast<std::size_t>(k)]);
            const double off = channel_of(colour, evidence.channels, look.channels, k) - looks - tone.of(looks);
            squares += off * off;
        }
        const double sigma = static_cast<double>(spot.sigma);
        // All against a thing of any colour.
        const double as_body = std::exp(-0.5 * squares / (sigma * sigma) + look.channels * (log_range - 0.5 * log_two_pi - std::log(sigma)));
        const double as_else = clutter + (1 - clutter) * std::exp(std::min(static_cast<double>(evidence.as_background[s.pixel]), 50.0));
        sum += std::log((1 - settings.otherwise) * as_body / as_else + settings.otherwise);
    }
    const double unusual = std::hypot(tone.light / settings.light_sigma, tone.contrast / settings.contrast_sigma);
    score.per_spot = (sum - 0.5 * unusual * unusual) / score.spots;
    return score;
}

double log_odds_of_look(const LearnedBody& body, double per_spot) {
    const auto log_density = [](double off, double sigma) { return -2.5 * std::log1p(off * off / (4 * sigma * sigma)) - std::log(sigma); };
    return log_density(std::min(per_spot - body.as_robot.mean, 0.0), body.as_robot.sigma) -
           log_density(std::max(per_spot - body.as_clutter.mean, 0.0), body.as_clutter.sigma);
}

}  // namespace roomfix
