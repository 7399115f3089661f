// Section 3 of Chou and Tsai 1986: finding corner lines by image analysis techniques.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/corner/chou1986.hpp"

namespace roomfix {
namespace {

using Eigen::Vector2d;

constexpr int angles = 180;  // alpha in steps of 1 deg, rho in steps of 1 px

/// x cos(alpha) + y sin(alpha) = rho, its edge points and the two ends of their longest unbroken part.
struct Line {
    double alpha = 0, rho = 0;
    std::vector<Vector2d> points;
    std::array<Vector2d, 2> ends;
    double votes = 0;

    Vector2d normal() const { return {std::cos(alpha), std::sin(alpha)}; }
    double distance(const Vector2d& p) const { return normal().dot(p) - rho; }
};

/// 3.1: Sobel operators in both directions, thresholds, and thinning of each direction's edge points; both results superimposed.
std::vector<Eigen::Vector2i> thinned_edge_points(LumaView frame, const Chou1986Settings& settings) {
    const int w = frame.width;
    const int h = frame.height;
    std::array<std::vector<int>, 2> sobel;
    for (auto& s : sobel) s.assign(static_cast<std::size_t>(w * h), 0);
    int strongest = 0;
    std::vector<std::size_t> histogram(2048, 0);
    for (int y = 1; y + 1 < h; ++y) {
        const std::uint8_t* a = frame.row(y - 1);
        const std::uint8_t* b = frame.row(y);
        const std::uint8_t* c = frame.row(y + 1);
        for (int x = 1; x + 1 < w; ++x) {
            const auto i = static_cast<std::size_t>(y * w + x);
            sobel[0][i] = std::abs(a[x + 1] - a[x - 1] + 2 * (b[x + 1] - b[x - 1]) + c[x + 1] - c[x - 1]);
            sobel[1][i] = std::abs(c[x - 1] - a[x - 1] + 2 * (c[x] - a[x]) + c[x + 1] - a[x + 1]);
            for (const auto& s : sobel) {
                strongest = std::max(strongest, s[i]);
                ++histogram[static_cast<std::size_t>(std::min(s[i], 2047))];
            }
        }
    }
    double threshold = std::max(settings.edge_threshold * strongest, 8.0);
    std::size_t above = 0;
    for (int i = 2047; i > threshold; --i) {
        above += histogram[static_cast<std::size_t>(i)];
        if (above > static_cast<std::size_t>(settings.most_points)) threshold = i;
    }
    // Shanmugan and Paul thin along the direction of the operator: of a run of edge points the strongest stays.
    std::vector<char> edge(static_cast<std::size_t>(w * h), 0);
    const auto thin = [&](const std::vector<int>& strength, int lines, int line_step, int count, int step) {
        for (int line = 0; line < lines; ++line) {
            int best = -1;
            for (int i = 0; i <= count; ++i) {
                const auto at = [&](int j) { return static_cast<std::size_t>(line * line_step + j * step); };
                const bool on = i < count && strength[at(i)] > threshold;
                if (on && (best < 0 || strength[at(i)] > strength[at(best)])) best = i;
                if (!on && best >= 0) {
                    edge[at(best)] = 1;
                    best = -1;
                }
            }
        }
    };
    thin(sobel[0], h, w, w, 1);
    thin(sobel[1], w, 1, h, w);
    std::vector<Eigen::Vector2i> points;
    for (int y = 0; y < h; ++y) {
        for (int x = 0; x < w; ++x) {
            if (edge[static_cast<std::size_t>(y * w + x)]) points.emplace_back(x, y);
        }
    }
    return points;
}

/// The longest part of the points along a line without a break; keeps only these.
bool cut_to_longest_part(Line& line, double largest_break) {
    const Vector2d along(-line.normal().y(), line.normal().x());
    std::sort(line.points.begin(), line.points.end(), [&](const Vector2d& a, const Vector2d& b) { return along.dot(a) < along.dot(b); });
    std::size_t first = 0, best_first = 0, best_count = 0;
    for (std::size_t i = 1; i <= line.points.size(); ++i) {
        if (i < line.points.size() && along.dot(line.points[i] - line.points[i - 1]) <= largest_break) continue;
        if (i - first > best_count) {
            best_first = first;
            best_count = i - first;
        }
        first = i;
    }
    if (best_count < 8) return false;
    line.points = {line.points.begin() + static_cast<std::ptrdiff_t>(best_first), line.points.begin() + static_cast<std::ptrdiff_t>(best_first + best_count)};
    line.ends = {line.points.front(), line.points.back()};
    return true;
}

/// 3.2: the cell array H, H'(alpha, rho) = H(alpha, rho - 1) + H(alpha, rho) + H(alpha, rho + 1), and its local maxima.
std::vector<Line> hough_lines(const std::vector<Vector2d>& points, const Chou1986Settings& settings) {
    double farthest = 1;
    for (const Vector2d& p : points) farthest = std::max(farthest, p.norm());
    const int half = static_cast<int>(std::ceil(farthest)) + 2;
    const int distances = 2 * half + 1;
    std::vector<int> cells(static_cast<std::size_t>(angles * distances), 0);
    for (int a = 0; a < angles; ++a) {
        const double c = std::cos(a * std::numbers::pi / angles);
        const double s = std::sin(a * std::numbers::pi / angles);
        for (const Vector2d& p : points) ++cells[static_cast<std::size_t>(a * distances + half + static_cast<int>(std::lround(p.x() * c + p.y() * s)))];
    }
    const auto smoothed = [&](int a, int r) {
        if (a < 0 || a >= angles) {  // half a turn further the same line has the opposite distance
            a += a < 0 ? angles : -angles;
            r = 2 * half - r;
        }
        if (r < 1 || r + 1 >= distances) return 0;
        const auto i = static_cast<std::size_t>(a * distances + r);
        return cells[i - 1] + cells[i] + cells[i + 1];
    };
    std::vector<Line> lines;
    for (int a = 0; a < angles; ++a) {
        for (int r = 1; r + 1 < distances; ++r) {
            const int here = smoothed(a, r);
            if (here <= settings.least_votes) continue;
            bool largest = true;
            for (int da = -4; da <= 4 && largest; ++da) {
                for (int dr = -4; dr <= 4 && largest; ++dr) {
                    if (da == 0 && dr == 0) continue;
                    const int other = smoothed(a + da, r + dr);
                    largest = other < here || (other == here && (da > 0 || (da == 0 && dr > 0)));
                }
            }
            if (!largest) continue;
            Line line;
            line.alpha = a * std::numbers::pi / angles;
            line.rho = r - half;
            line.votes = here;
            lines.push_back(line);
        }
    }
    std::stable_sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) { return a.votes > b.votes; });
    if (lines.size() > settings.most_lines) lines.resize(settings.most_lines);
    for (Line& line : lines) {
        for (const Vector2d& p : points) {
            if (std::abs(line.distance(p)) <= settings.point_gap) line.points.push_back(p);
        }
    }
    std::erase_if(lines, [&](Line& line) { return !cut_to_longest_part(line, settings.largest_break); });
    return lines;
}

std::optional<Vector2d> crossing(const Line& a, const Line& b) {
    const double determinant = std::sin(b.alpha - a.alpha);
    if (std::abs(determinant) < 0.1) return std::nullopt;
    return Vector2d((a.rho * std::sin(b.alpha) - b.rho * std::sin(a.alpha)) / determinant,
                    (b.rho * std::cos(a.alpha) - a.rho * std::cos(b.alpha)) / determinant);
}

/// 3.4: (17) minimised; atan2 instead of print's atan, which divides by zero for lines along an axis.
void lse_fit(Line& line) {
    const double n = static_cast<double>(line.points.size());
    double sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
    for (const Vector2d& p : line.points) {
        sx += p.x();
        sy += p.y();
        sxx += p.x() * p.x();
        syy += p.y() * p.y();
        sxy += p.x() * p.y();
    }
    const double a = syy - sxx + (sx * sx - sy * sy) / n;
    const double b = sxy - sx * sy / n;
    line.alpha = std::atan2(a - std::sqrt(a * a + 4 * b * b), 2 * b);
    line.rho = (std::cos(line.alpha) * sx + std::sin(line.alpha) * sy) / n;
}

/// 3.5: the same through a common point. The constraint is rho - x0 cos(alpha) - y0 sin(alpha) = 0; print has a plus sign once.
void lse_refit(Line& line, const Vector2d& common) {
    double a = 0, b = 0;
    for (const Vector2d& p : line.points) {
        const Vector2d d = p - common;
        a += d.y() * d.y() - d.x() * d.x();
        b += d.x() * d.y();
    }
    line.alpha = std::atan2(a - std::sqrt(a * a + 4 * b * b), 2 * b);
    line.rho = line.normal().dot(common);
}

/// The point that the pairs' crossings agree on; nothing if they do not (check 2).
std::optional<Vector2d> common_point(const std::array<const Line*, 3>& triple, double gap) {
    std::array<Vector2d, 3> crossings;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto p = crossing(*triple[i], *triple[(i + 1) % 3]);
        if (!p) return std::nullopt;
        crossings[i] = *p;
    }
    for (std::size_t i = 0; i < 3; ++i) {
        if ((crossings[i] - crossings[(i + 1) % 3]).norm() > gap) return std::nullopt;
    }
    return Vector2d((crossings[0] + crossings[1] + crossings[2]) / 3);
}

}  // namespace

std::optional<CornerRays> Chou1986::find_lines(LumaView frame, std::string* reason) const {
    const auto give_up = [&](const char* why) {
        if (reason) *reason = why;
        return std::nullopt;
    };
    if (frame.width < 16 || frame.height < 16) return give_up("the picture is too small for the published method");
    const double f = 0.5 * (model_.fx + model_.fy);
    std::vector<Vector2d> points;
    for (const Eigen::Vector2i& p : thinned_edge_points(frame, settings_)) {
        const auto ray = unproject(model_, p.cast<double>());
        if (ray && ray->norm() < 3) points.push_back(f * *ray);
    }
    std::vector<Line> lines = hough_lines(points, settings_);
    const auto at_border = [&](const Vector2d& p) {
        const auto pixel = project(model_, (p / f).homogeneous());
        return !pixel || !model_.contains(*pixel, settings_.border_gap);
    };
    // 3.3: of the triples that pass the checks the one with the most votes.
    double best = 0;
    std::optional<std::array<std::size_t, 3>> found;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        for (std::size_t j = i + 1; j < lines.size(); ++j) {
            for (std::size_t k = j + 1; k < lines.size(); ++k) {
                const std::array<const Line*, 3> triple = {&lines[i], &lines[j], &lines[k]};
                const auto common = common_point(triple, settings_.crossing_gap);
                if (!common) continue;
                std::array<Vector2d, 3> directions;
                bool fits = true;
                for (std::size_t l = 0; l < 3 && fits; ++l) {
                    const bool first = (triple[l]->ends[0] - *common).norm() < (triple[l]->ends[1] - *common).norm();
                    const Vector2d& near = triple[l]->ends[first ? 0 : 1];
                    const Vector2d& far = triple[l]->ends[first ? 1 : 0];
                    fits = (near - *common).norm() < settings_.end_gap && at_border(far);  // checks 1 and 3
                    directions[l] = (far - *common).normalized();
                }
                for (std::size_t l = 0; l < 3 && fits; ++l) {  // check 4: 90 to 180 deg
                    const double cosine = directions[l].dot(directions[(l + 1) % 3]);
                    fits = cosine < 0 && cosine > -1;
                }
                const double votes = triple[0]->votes + triple[1]->votes + triple[2]->votes;
                if (!fits || votes <= best) continue;
                best = votes;
                found = {{i, j, k}};
            }
        }
    }
    if (!found)
        return give_up(lines.size() < 3 ? "the published method found fewer than three lines"
                                        : "the published method found no three lines that pass its checks");
    std::array<Line, 3> corner = {lines[(*found)[0]], lines[(*found)[1]], lines[(*found)[2]]};
    for (Line& line : corner) lse_fit(line);
    const auto common = common_point({&corner[0], &corner[1], &corner[2]}, 4 * settings_.crossing_gap);
    if (!common) return give_up("the published method's lines do not meet after the fit");
    CornerRays rays;
    rays.corner = *common / f;
    for (std::size_t l = 0; l < 3; ++l) {
        lse_refit(corner[l], *common);
        const Vector2d along(-corner[l].normal().y(), corner[l].normal().x());
        const Vector2d middle = 0.5 * (corner[l].points.front() + corner[l].points.back());
        rays.directions[l] = along.dot(middle - *common) > 0 ? along : Vector2d(-along);
    }
    // The picture's lower line is the walls'.
    const auto labelled = labellings(rays);
    return *std::max_element(labelled.begin(), labelled.end(),
                             [](const CornerRays& a, const CornerRays& b) { return a.directions[wall_edge].y() < b.directions[wall_edge].y(); });
}

std::optional<CornerView> Chou1986::locate(LumaView frame, std::string* reason) const {
    const auto rays = find_lines(frame, reason);
    if (!rays) return std::nullopt;
    const auto view = chou1986_view(*rays);
    if (!view && reason) *reason = "none of the closed form's roots sees the three lines from inside the room";
    return view;
}

}  // namespace roomfix
