#include "roomfix/imaging/components.hpp"

#include <algorithm>
#include <climits>

namespace roomfix {

int ComponentFinder::root(int label) {
    auto& parents = parents_;
    while (parents[static_cast<std::size_t>(label)] != label) {
        auto& parent = parents[static_cast<std::size_t>(label)];
        parent = parents[static_cast<std::size_t>(parent)];
        label = parent;
    }
    return label;
}

int ComponentFinder::join(int a, int b) {
    a = root(a);
    b = root(b);
    if (a == b) return a;
    if (b < a) std::swap(a, b);
    parents_[static_cast<std::size_t>(b)] = a;
    Sums& to = sums_[static_cast<std::size_t>(a)];
    const Sums& from = sums_[static_cast<std::size_t>(b)];
    to = {to.area + from.area,
          to.x + from.x,
          to.y + from.y,
          to.xx + from.xx,
          to.xy + from.xy,
          to.yy + from.yy,
          std::min(to.left, from.left),
          std::min(to.top, from.top),
          std::max(to.right, from.right),
          std::max(to.bottom, from.bottom)};
    return a;
}

/// The runs of set pixels of row y, left to right, into current_.
void ComponentFinder::read_runs(const BitMask& mask, int y) {
    current_.clear();
    const std::uint64_t* words = mask.row(y);
    const WordSpan span = mask.span(y);
    int begin = -1;
    for (int w = span.first; w < span.last; ++w) {
        const std::uint64_t word = words[w];
        const int base = w << 6;
        int bit = 0;
        while (bit < 64) {
            const std::uint64_t rest = (begin < 0 ? word : ~word) >> bit;
            if (rest == 0) break;
            bit += std::countr_zero(rest);
            if (begin < 0) {
                begin = base + bit;
            } else {
                current_.push_back({begin, base + bit, -1});
                begin = -1;
            }
        }
    }
    if (begin >= 0) current_.push_back({begin, std::min(span.last << 6, mask.width()), -1});
}

void ComponentFinder::add_run(const Run& run, int y) {
    // Sums over x = begin .. end-1 in closed form.
    const std::int64_t n = run.end - run.begin;
    const std::int64_t a = run.begin;
    const std::int64_t sum_x = n * (a + run.end - 1) / 2;
    const std::int64_t offset_squares = (n - 1) * n * (2 * n - 1) / 6;
    const std::int64_t sum_xx = n * a * a + a * (n - 1) * n + offset_squares;
    Sums& s = sums_[static_cast<std::size_t>(run.label)];
    s.area += n;
    s.x += sum_x;
    s.y += n * y;
    s.xx += sum_xx;
    s.xy += sum_x * y;
    s.yy += n * y * y;
    s.left = std::min(s.left, run.begin);
    s.right = std::max(s.right, run.end - 1);
    s.top = std::min(s.top, y);
    s.bottom = std::max(s.bottom, y);
}

const std::vector<Component>& ComponentFinder::find(const BitMask& mask, std::int64_t min_area) {
    above_.clear();
    parents_.clear();
    sums_.clear();
    components_.clear();
    for (int y = 0; y < mask.height(); ++y) {
        if (mask.span(y).empty()) {
            above_.clear();
            continue;
        }
        read_runs(mask, y);
        std::size_t first = 0;
        for (Run& run : current_) {
            while (first < above_.size() && above_[first].end < run.begin) ++first;
            for (std::size_t i = first; i < above_.size() && above_[i].begin <= run.end; ++i) {
                run.label = run.label < 0 ? root(above_[i].label) : join(run.label, above_[i].label);
            }
            if (run.label < 0) {
                run.label = static_cast<int>(parents_.size());
                parents_.push_back(run.label);
                sums_.push_back({0, 0, 0, 0, 0, 0, INT_MAX, INT_MAX, INT_MIN, INT_MIN});
            }
            add_run(run, y);
        }
        std::swap(above_, current_);
    }
    for (std::size_t i = 0; i < parents_.size(); ++i) {
        const Sums& s = sums_[i];
        if (parents_[i] != static_cast<int>(i) || s.area < min_area) continue;
        const double n = static_cast<double>(s.area);
        Component c{s.area, s.left, s.top, s.right, s.bottom};
        c.centroid = {static_cast<double>(s.x) / n, static_cast<double>(s.y) / n};
        const double xy = static_cast<double>(s.xy) / n - c.centroid.x() * c.centroid.y();
        c.covariance << static_cast<double>(s.xx) / n - c.centroid.x() * c.centroid.x(), xy, xy,
            static_cast<double>(s.yy) / n - c.centroid.y() * c.centroid.y();
        components_.push_back(c);
    }
    std::sort(components_.begin(), components_.end(), [](const Component& a, const Component& b) {
        if (a.area != b.area) return a.area > b.area;
        return a.top != b.top ? a.top < b.top : a.left < b.left;
    });
    return components_;
}

}  // namespace roomfix
