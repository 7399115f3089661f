#include "roomfix/evaluate/line_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace roomfix {
namespace {

constexpr double width = 760, height = 460, left = 72, right = 20, top = 46, bottom = 54;
constexpr std::array<const char*, 6> colours = {"#1f6fb4", "#d9601a", "#2a8a57", "#8a4fbf", "#b5304b", "#555555"};

std::string escaped(const std::string& text) {
    std::string safe;
    for (const char c : text) safe += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
    return safe;
}

/// Round numbers from low to high, some six of them.
std::vector<double> round_ticks(double low, double high) {
    const double rough = std::max((high - low) / 6, 1e-12);
    const double power = std::pow(10, std::floor(std::log10(rough)));
    const double unit = rough / power;
    const double step = power * (unit < 1.5 ? 1 : unit < 3.5 ? 2 : unit < 7.5 ? 5 : 10);
    std::vector<double> ticks;
    for (double v = std::floor(low / step + 1e-9) * step; v < high + 0.999 * step; v += step) ticks.push_back(std::abs(v) < 1e-9 * step ? 0 : v);
    return ticks;
}

std::vector<double> decades(double low, double high) {
    std::vector<double> ticks;
    for (double v = std::pow(10, std::floor(std::log10(low))); v < high * 9.99; v *= 10) ticks.push_back(v);
    return ticks;
}

}  // namespace

std::string svg_of(const LineChart& chart) {
    Eigen::Vector2d low(1e300, 1e300), high(-1e300, -1e300);
    for (const Curve& curve : chart.curves) {
        for (const auto& p : curve.points) {
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
    }
    if (!(low.x() <= high.x())) low = high = Eigen::Vector2d::Zero();
    const std::vector<double> xs = round_ticks(low.x(), high.x());
    if (!chart.logarithmic) low.y() = std::min(low.y(), 0.0);
    const std::vector<double> ys = chart.logarithmic ? decades(std::max(low.y(), 1e-9), high.y()) : round_ticks(low.y(), high.y());
    const auto scaled_y = [&](double y) { return chart.logarithmic ? std::log10(std::max(y, 1e-12)) : y; };
    const auto at = [&](double x, double y) {
        const double u = (x - xs.front()) / std::max(xs.back() - xs.front(), 1e-12);
        const double v = (scaled_y(y) - scaled_y(ys.front())) / std::max(scaled_y(ys.back()) - scaled_y(ys.front()), 1e-12);
        return Eigen::Vector2d(left + u * (width - left - right), height - bottom - v * (height - top - bottom));
    };
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" font-family=\"sans-serif\" font-size=\"12\">\n"
        "<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n<text x=\"{2}\" y=\"24\" font-size=\"15\" font-weight=\"600\" fill=\"#222\">{3}</text>\n",
        width, height, left, escaped(chart.title));
    for (const double x : xs) {
        const Eigen::Vector2d p = at(x, ys.front());
        svg += fmt::format(
            "<path d=\"M{:.1f},{:.1f}V{:.1f}\" stroke=\"#e4e4e4\"/><text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\" fill=\"#444\">{:g}</text>\n", p.x(),
            p.y(), top, p.x(), p.y() + 18, x);
    }
    for (const double y : ys) {
        const Eigen::Vector2d p = at(xs.front(), y);
        svg +=
            fmt::format("<path d=\"M{:.1f},{:.1f}H{:.1f}\" stroke=\"#e4e4e4\"/><text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\" fill=\"#444\">{:g}</text>\n",
                        p.x(), p.y(), width - right, p.x() - 8, p.y() + 4, y);
    }
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\" fill=\"#222\">{}</text>\n", left + 0.5 * (width - left - right), height - 12,
                       escaped(chart.x_label));
    svg += fmt::format("<text transform=\"translate(18 {:.1f}) rotate(-90)\" text-anchor=\"middle\" fill=\"#222\">{}</text>\n",
                       top + 0.5 * (height - top - bottom), escaped(chart.y_label));
    double legend = top + 10;
    for (std::size_t i = 0; i < chart.curves.size(); ++i) {
        const Curve& curve = chart.curves[i];
        if (curve.points.empty()) continue;
        const char* colour = colours[i % colours.size()];
        const char* dash = curve.dashed ? " stroke-dasharray=\"6 4\"" : "";
        std::string path;
        for (const auto& point : curve.points) {
            const Eigen::Vector2d p = at(point.x(), point.y());
            path += fmt::format("{}{:.1f},{:.1f}", path.empty() ? "M" : "L", p.x(), p.y());
        }
        svg += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"{}/>\n", path, colour, dash);
        const double x = width - right - 300;
        svg += fmt::format("<path d=\"M{:.1f},{:.1f}h26\" stroke=\"{}\" stroke-width=\"2\"{}/><text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"#222\">{}</text>\n", x,
                           legend, colour, dash, x + 34, legend + 4, escaped(curve.name));
        legend += 18;
    }
    return svg + "</svg>\n";
}

}  // namespace roomfix
