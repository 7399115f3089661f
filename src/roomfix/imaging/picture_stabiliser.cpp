#include "roomfix/imaging/picture_stabiliser.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr int grid_step = 16;  // px

int grid_size(int length) { return (length - 1 + grid_step - 1) / grid_step + 1; }

}  // namespace

void PictureStabiliser::set_reference(const PictureView& reference) {
    alignment_.set_reference(reference.grey);
    reference_ = copy_of(reference.grey);
    reference_colour_ = reference.colour ? *reference.colour : ColourImage();
    turned_back_ = false;
    looked_.reset();
}

/// Where the reference's pixels are in the frame.
void PictureStabiliser::find_sources() {
    const CameraModel& model = alignment_.model();
    const int across = grid_size(model.width), down = grid_size(model.height);
    grid_.resize(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
    auto source = grid_.begin();
    for (int y = 0; y < down; ++y) {
        for (int x = 0; x < across; ++x, ++source) {
            const auto ray = unproject(model, {x * grid_step, y * grid_step});
            const auto pixel = ray ? seen_after(model, *ray, found_.motion) : std::nullopt;
            *source = pixel.value_or(Eigen::Vector2d::Constant(-1e6)).cast<float>();
        }
    }
}

/// Sources, px of the frame, of a row of a picture that is `scale` times smaller.
void PictureStabiliser::turn_back_row(int y, int scale, int width, std::vector<Eigen::Vector2f>& sources) const {
    const int across = grid_size(alignment_.model().width), down = grid_size(alignment_.model().height);
    const auto in_full = [scale](int i) { return (static_cast<float>(i) + 0.5f) * static_cast<float>(scale) - 0.5f; };
    const float row = in_full(y) / grid_step;
    const int line = std::clamp(static_cast<int>(row), 0, down - 2);
    const float below = row - static_cast<float>(line);
    const Eigen::Vector2f* upper = grid_.data() + static_cast<std::ptrdiff_t>(line) * across;
    sources.resize(static_cast<std::size_t>(width));
    for (int x = 0; x < width; ++x) {
        const float at = in_full(x) / grid_step;
        const int column = std::clamp(static_cast<int>(at), 0, across - 2);
        const float right = at - static_cast<float>(column);
        const auto along = [&](const Eigen::Vector2f* knots) { return Eigen::Vector2f(knots[column] + right * (knots[column + 1] - knots[column])); };
        const Eigen::Vector2f above = along(upper);
        sources[static_cast<std::size_t>(x)] = above + below * (along(upper + across) - above);
    }
}

void PictureStabiliser::turn_back(LumaView frame) {
    grey_.resize(frame.width, frame.height);
    for (int y = 0; y < frame.height; ++y) {
        turn_back_row(y, 1, frame.width, sources_);
        std::uint8_t* to = grey_.row(y);
        const std::uint8_t* instead = reference_.row(y);
        for (int x = 0; x < frame.width; ++x) {
            const Eigen::Vector2f& from = sources_[static_cast<std::size_t>(x)];
            const bool inside =
                from.x() >= 0 && from.y() >= 0 && from.x() < static_cast<float>(frame.width - 1) && from.y() < static_cast<float>(frame.height - 1);
            to[x] = inside ? static_cast<std::uint8_t>(sample(frame, from.x(), from.y()) + 0.5f) : instead[x];
        }
    }
}

void PictureStabiliser::turn_back(const ColourImage& frame) {
    const auto channels = static_cast<std::size_t>(frame.channels);
    const auto stride = static_cast<std::size_t>(frame.width) * channels;
    colour_.width = frame.width;
    colour_.height = frame.height;
    colour_.channels = frame.channels;
    colour_.scale = frame.scale;
    colour_.values.resize(frame.values.size());
    const bool same_kind = reference_colour_.values.size() == frame.values.size();
    for (int y = 0; y < frame.height; ++y) {
        turn_back_row(y, frame.scale, frame.width, sources_);
        for (int x = 0; x < frame.width; ++x) {
            const Eigen::Vector2f from =
                (sources_[static_cast<std::size_t>(x)] + Eigen::Vector2f(0.5f, 0.5f)) / static_cast<float>(frame.scale) - Eigen::Vector2f(0.5f, 0.5f);
            const std::size_t here = static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x) * channels;
            const bool inside =
                from.x() >= 0 && from.y() >= 0 && from.x() < static_cast<float>(frame.width - 1) && from.y() < static_cast<float>(frame.height - 1);
            if (!inside) {
                for (std::size_t k = 0; k < channels; ++k) colour_.values[here + k] = same_kind ? reference_colour_.values[here + k] : frame.values[here + k];
                continue;
            }
            const int column = static_cast<int>(from.x()), line = static_cast<int>(from.y());
            const float right = from.x() - static_cast<float>(column), down = from.y() - static_cast<float>(line);
            const std::uint8_t* upper = frame.values.data() + static_cast<std::size_t>(line) * stride + static_cast<std::size_t>(column) * channels;
            const std::uint8_t* lower = upper + stride;
            for (std::size_t k = 0; k < channels; ++k) {
                const auto along = [&](const std::uint8_t* row) {
                    return static_cast<float>(row[k]) + right * (static_cast<float>(row[k + channels]) - static_cast<float>(row[k]));
                };
                colour_.values[here + k] = static_cast<std::uint8_t>(along(upper) + down * (along(lower) - along(upper)) + 0.5f);
            }
        }
    }
}

PictureView PictureStabiliser::steady(const PictureView& frame, std::optional<Nanoseconds> time) {
    if (!has_reference()) return frame;
    if (!time || !looked_ || std::abs(to_seconds(*time - *looked_)) >= settings_.interval) {
        looked_ = time;
        found_ = alignment_.align(frame.grey);
        const bool shows_reference = found_.nats > settings_.prior && found_.showing > settings_.showing;
        turned_back_ = shows_reference && found_.offset > settings_.least * colour_scale(frame.grey.width);
        if (turned_back_) find_sources();
    }
    if (!turned_back_) return frame;
    turn_back(frame.grey);
    if (!frame.colour) return grey_;
    turn_back(*frame.colour);
    return {grey_, &colour_};
}

}  // namespace roomfix
