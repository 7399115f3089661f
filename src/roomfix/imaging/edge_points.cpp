#include "roomfix/imaging/edge_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace roomfix {
namespace {

constexpr int scale = 4;         // of the reduced picture's grey levels
constexpr float sobel_gain = 8;  // of a Sobel operator: a slope of 1 per px gives 8
constexpr int histogram_bins = 1024;

}  // namespace

void EdgePointFinder::reduce(LumaView frame) {
    reduction_ = std::max(1, static_cast<int>(std::lround(static_cast<double>(frame.width) / settings_.working_width)));
    width_ = frame.width / reduction_;
    height_ = frame.height / reduction_;
    small_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(std::max(height_, 0)));
    const int k = reduction_;
    for (int y = 0; y < height_; ++y) {
        std::int16_t* out = small_.data() + static_cast<std::ptrdiff_t>(y) * width_;
        if (k == 1) {
            const std::uint8_t* row = frame.row(y);
            for (int x = 0; x < width_; ++x) out[x] = static_cast<std::int16_t>(row[x] * scale);
        } else if (k == 2) {
            const std::uint8_t* first = frame.row(2 * y);
            const std::uint8_t* second = frame.row(2 * y + 1);
            for (int x = 0; x < width_; ++x) out[x] = static_cast<std::int16_t>(first[2 * x] + first[2 * x + 1] + second[2 * x] + second[2 * x + 1]);
        } else {
            sums_.assign(static_cast<std::size_t>(width_), 0);
            for (int j = 0; j < k; ++j) {
                const std::uint8_t* row = frame.row(k * y + j);
                for (int x = 0; x < width_; ++x) {
                    std::uint32_t sum = 0;
                    for (int i = 0; i < k; ++i) sum += row[k * x + i];
                    sums_[static_cast<std::size_t>(x)] += sum;
                }
            }
            const auto area = static_cast<std::uint32_t>(k * k);
            for (int x = 0; x < width_; ++x) out[x] = static_cast<std::int16_t>((sums_[static_cast<std::size_t>(x)] * scale + area / 2) / area);
        }
    }
}

/// Sobel in both directions, and |across| + |down|.
void EdgePointFinder::differentiate() {
    across_.assign(small_.size(), 0);
    down_.assign(small_.size(), 0);
    size_.assign(small_.size(), 0);
    for (int y = 1; y + 1 < height_; ++y) {
        const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(y) * width_;
        const std::int16_t* above = small_.data() + start - width_;
        const std::int16_t* here = small_.data() + start;
        const std::int16_t* below = small_.data() + start + width_;
        std::int16_t* gx = across_.data() + start;
        std::int16_t* gy = down_.data() + start;
        std::int16_t* size = size_.data() + start;
        for (int x = 1; x + 1 < width_; ++x) {
            const int h = (above[x + 1] - above[x - 1]) + 2 * (here[x + 1] - here[x - 1]) + (below[x + 1] - below[x - 1]);
            const int v = (below[x - 1] - above[x - 1]) + 2 * (below[x] - above[x]) + (below[x + 1] - above[x + 1]);
            gx[x] = static_cast<std::int16_t>(h);
            gy[x] = static_cast<std::int16_t>(v);
            size[x] = static_cast<std::int16_t>(std::abs(h) + std::abs(v));
        }
    }
}

/// The smallest |across| + |down| that counts. Most of a picture is no edge: the median of the sizes tells the noise.
std::int32_t EdgePointFinder::threshold() {
    std::array<std::uint32_t, histogram_bins> histogram{};
    std::uint32_t total = 0;
    for (int y = 1; y + 1 < height_; y += 2) {
        const std::int16_t* size = size_.data() + static_cast<std::ptrdiff_t>(y) * width_;
        for (int x = 1 + (y & 2) / 2; x + 1 < width_; x += 3, ++total) ++histogram[static_cast<std::size_t>(std::min<int>(size[x], histogram_bins - 1))];
    }
    std::uint32_t below = 0;
    int median = 0;
    while (median < histogram_bins - 1 && 2 * (below + histogram[static_cast<std::size_t>(median)]) < total)
        below += histogram[static_cast<std::size_t>(median++)];
    // The median of |g| + |h| of two independent normal g and h is 1.55 standard deviations.
    const double sigma = std::max(median + 0.5, 1.0) / 1.55;
    noise_ = sigma / (static_cast<double>(sobel_gain) * scale);
    double limit = std::max(settings_.threshold * sigma, settings_.least_gradient * static_cast<double>(sobel_gain) * scale);
    // A picture full of texture: only its strongest edges.
    const double sampled = 6;  // one pixel in six is in the histogram; about one in three above the limit is the largest across its edge
    std::uint32_t above = 0;
    for (int i = histogram_bins - 1; i > limit; --i) {
        above += histogram[static_cast<std::size_t>(i)];
        if (above * sampled > 3.0 * static_cast<double>(settings_.most_points)) {
            limit = i;
            break;
        }
    }
    return static_cast<std::int32_t>(std::ceil(limit));
}

void EdgePointFinder::find(LumaView frame, std::vector<EdgePoint>& points) {
    points.clear();
    reduce(frame);
    if (width_ < 5 || height_ < 5) return;
    differentiate();
    const std::int32_t limit = threshold();
    const float to_noise = static_cast<float>(1 / (static_cast<double>(sobel_gain) * scale * noise_));
    const float k = static_cast<float>(reduction_);
    for (int y = 2; y + 2 < height_; ++y) {
        const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(y) * width_;
        const std::int16_t* size = size_.data() + start;
        for (int x = 2; x + 2 < width_; ++x) {
            if (size[x] < limit) continue;
            const float gx = across_[static_cast<std::size_t>(start + x)];
            const float gy = down_[static_cast<std::size_t>(start + x)];
            // The gradient's neighbours one step along its larger part, interpolated.
            const bool level = std::abs(gx) >= std::abs(gy);
            const float ratio = level ? gy / gx : gx / gy;
            const auto square = [&](std::ptrdiff_t i) {
                const float h = across_[static_cast<std::size_t>(i)];
                const float v = down_[static_cast<std::size_t>(i)];
                return h * h + v * v;
            };
            const auto beside = [&](int side) {
                const std::ptrdiff_t main = level ? side : side * width_;
                const std::ptrdiff_t other = (level ? width_ : 1) * ((ratio > 0) == (side > 0) ? 1 : -1);
                const float part = std::abs(ratio);
                return std::sqrt((1 - part) * square(start + x + main) + part * square(start + x + main + other));
            };
            const float here = std::sqrt(gx * gx + gy * gy);
            const float before = beside(-1);
            const float after = beside(1);
            if (here < before || here <= after) continue;
            const float bend = before - 2 * here + after;
            const float shift = bend < 0 ? std::clamp(0.5f * (before - after) / bend, -0.5f, 0.5f) : 0.0f;
            const float px = static_cast<float>(x) + shift * (level ? 1.0f : ratio);
            const float py = static_cast<float>(y) + shift * (level ? ratio : 1.0f);
            // The middle of a reduced pixel is the middle of its block.
            points.push_back({k * px + 0.5f * (k - 1), k * py + 0.5f * (k - 1), gx / here, gy / here, here * to_noise});
        }
    }
    if (points.size() > settings_.most_points) {
        const auto middle = points.begin() + static_cast<std::ptrdiff_t>(settings_.most_points);
        std::nth_element(points.begin(), middle, points.end(), [](const EdgePoint& a, const EdgePoint& b) { return a.strength > b.strength; });
        points.resize(settings_.most_points);
    }
}

}  // namespace roomfix
