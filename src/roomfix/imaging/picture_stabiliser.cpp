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

/// `scale`: pixels of the full picture per pixel of these. Within a cell of the grid, sources lie along a straight line.
template <int Channels>
void PictureStabiliser::turn_back(const Plane& frame, const Plane& reference, int scale, std::uint8_t* to, std::ptrdiff_t stride) const {
    constexpr float one = 65536;  // px, of sources
    const int across = grid_size(alignment_.model().width), down = grid_size(alignment_.model().height);
    const auto in_full = [scale](int i) { return (static_cast<float>(i) + 0.5f) * static_cast<float>(scale) - 0.5f; };
    const auto inside = [](int source, int length) { return source >= 0 && source < (length - 1) << 16; };
    for (int y = 0; y < frame.height; ++y, to += stride) {
        const float row = in_full(y) / grid_step;
        const int line = std::clamp(static_cast<int>(row), 0, down - 2);
        const Eigen::Vector2f* upper = grid_.data() + static_cast<std::ptrdiff_t>(line) * across;
        const auto knot = [&](int column) {
            const Eigen::Vector2f& above = upper[column];
            return Eigen::Vector2f(above + (row - static_cast<float>(line)) * (upper[column + across] - above));
        };
        std::uint8_t* here = to;
        for (int cell = 0, x = 0; x < frame.width; ++cell) {
            cell = std::min(cell, across - 2);
            const int end = cell == across - 2 ? frame.width : std::min(((cell + 1) * grid_step + scale - 1) / scale, frame.width);
            const Eigen::Vector2f left = knot(cell), step = (knot(cell + 1) - left) / grid_step;
            const Eigen::Vector2f half = Eigen::Vector2f::Constant(0.5f);
            const Eigen::Vector2f first = (left + (in_full(x) - static_cast<float>(cell * grid_step)) * step + half) / static_cast<float>(scale) - half;
            const Eigen::Vector2i each = (step * one).cast<int>();
            Eigen::Vector2i source = (first.cwiseMax(-1e4f).cwiseMin(3e4f) * one).cast<int>();
            for (; x < end; ++x, source += each, here += Channels) {
                if (!inside(source.x(), frame.width) || !inside(source.y(), frame.height)) {
                    std::copy_n(reference.values + y * reference.stride + static_cast<std::ptrdiff_t>(x) * Channels, Channels, here);
                    continue;
                }
                const int right = (source.x() >> 8) & 255, below = (source.y() >> 8) & 255;
                const std::uint8_t* above = frame.values + (source.y() >> 16) * frame.stride + static_cast<std::ptrdiff_t>(source.x() >> 16) * Channels;
                const std::uint8_t* under = above + frame.stride;
                for (int k = 0; k < Channels; ++k) {
                    const int high = 256 * above[k] + right * (above[k + Channels] - above[k]), low = 256 * under[k] + right * (under[k + Channels] - under[k]);
                    here[k] = static_cast<std::uint8_t>((256 * high + below * (low - high) + 32768) >> 16);
                }
            }
        }
    }
}

void PictureStabiliser::turn_back(LumaView frame) {
    grey_.resize(frame.width, frame.height);
    const LumaView reference = reference_.view();
    turn_back<1>({frame.data, frame.width, frame.height, frame.stride}, {reference.data, reference.width, reference.height, reference.stride}, 1, grey_.row(0),
                 grey_.view().stride);
}

void PictureStabiliser::turn_back(const ColourImage& frame) {
    colour_ = frame;
    const std::ptrdiff_t stride = static_cast<std::ptrdiff_t>(frame.width) * frame.channels;
    const Plane seen{frame.values.data(), frame.width, frame.height, stride};
    // Without a reference of that kind, what is not seen stays as the frame has it there.
    const bool same_kind = reference_colour_.channels == frame.channels && reference_colour_.values.size() == frame.values.size();
    const Plane reference{same_kind ? reference_colour_.values.data() : frame.values.data(), frame.width, frame.height, stride};
    if (frame.channels == 3) {
        turn_back<3>(seen, reference, frame.scale, colour_.values.data(), stride);
    } else {
        turn_back<1>(seen, reference, frame.scale, colour_.values.data(), stride);
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
