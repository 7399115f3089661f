#include "roomfix/imaging/spot_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/imaging/spot_sums.hpp"

namespace roomfix {
namespace {

// u, v, log of the amplitude, 1 / (2 width^2), ground, slope in x, slope in y: the logarithm of the light is linear in the third and
// fourth, so that wings without their saturated middle converge, too.
constexpr int unknowns = 7;
constexpr int largest_radius = 7;
constexpr double off_centre = 0.05;  // px: a window this far beside the spot pulls at it
using Vector = Eigen::Matrix<double, unknowns, 1>;
using Matrix = Eigen::Matrix<double, unknowns, unknowns>;

double steepness_of(double width) { return 0.5 / (width * width); }

struct Window {
    const std::uint8_t* pixels;  // top left
    std::ptrdiff_t stride;
    int size;
    double left, top;                                  // px, of the first pixel's centre
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();  // px: only pixels around here count ...
    double reach_squared = 1e9;                        // ... within this distance
    const SpotPrior* prior = nullptr;

    double centre_x() const { return left + 0.5 * (size - 1); }
    double centre_y() const { return top + 0.5 * (size - 1); }
};

/// The camera's response curve both ways, as tables: light 1 is grey level 255.
class Response {
public:
    explicit Response(double gamma) : gamma_(gamma) {
        for (std::size_t i = 0; i < light_.size(); ++i) light_[i] = std::pow(static_cast<double>(i) / 255, gamma);
        for (std::size_t i = 0; i < grey_.size(); ++i) grey_[i] = 255 * std::pow(static_cast<double>(i) / steps, 2 / gamma);
    }
    double gamma() const { return gamma_; }
    double light(double grey) const { return light_[static_cast<std::size_t>(std::clamp(grey, 0.0, 255.0) + 0.5)]; }
    /// Grey level of light 0..1 and its derivative.
    double grey(double light, double& slope) const {
        const double root = std::sqrt(std::clamp(light, 1e-6, 1.0));
        const double at = root * steps;
        const auto i = std::min(static_cast<std::size_t>(at), static_cast<std::size_t>(steps - 1));
        const double step = grey_[i + 1] - grey_[i];
        slope = step * steps / (2 * root);
        return grey_[i] + (at - static_cast<double>(i)) * step;
    }

private:
    static constexpr int steps = 1024;
    double gamma_;
    std::array<double, 256> light_;
    std::array<double, steps + 1> grey_;  // over the square root of the light: evenly fine where it is dark
};

/// What the unknowns make of the window.
struct Linearised {
    Matrix normal = Matrix::Zero();
    Vector gradient = Vector::Zero();
    double cost = 0;  // robust
};

constexpr float huber = 3;  // standard deviations beyond which a residual counts linearly

SpotModel model_of(const Window& window, const Vector& p, const SpotFitSettings& s) {
    const auto f = [](double value) { return static_cast<float>(value); };
    return {f(p[0] - window.centre_x()),
            f(p[1] - window.centre_y()),
            f(std::exp(p[2])),
            f(p[3]),
            f(p[4]),
            f(p[5]),
            f(p[6]),
            f(s.gamma),
            f(s.read_noise * s.read_noise + 1.0 / 12),
            f(s.shot_noise),
            f(s.saturated),
            huber};
}

Linearised linearise(const Window& window, const SpotPixels& pixels, const Vector& p, const SpotFitSettings& s) {
    SpotSums sums;
    simd::spot_sums(pixels, model_of(window, p, s), sums);
    Linearised l;
    std::size_t k = 0;
    for (int a = 0; a < unknowns; ++a) {
        for (int b = 0; b <= a; ++b) l.normal(a, b) = l.normal(b, a) = static_cast<double>(sums.normal[k++]);
        l.gradient[a] = static_cast<double>(sums.gradient[static_cast<std::size_t>(a)]);
    }
    l.cost = static_cast<double>(sums.cost);
    if (!window.prior) return l;
    const auto expect = [&](int i, double value, double sigma) {
        const double off = value - p[i];
        l.normal(i, i) += 1 / (sigma * sigma);
        l.gradient[i] += off / (sigma * sigma);
        l.cost += off * off / (sigma * sigma);
    };
    expect(2, std::log(window.prior->amplitude), window.prior->amplitude_sigma);
    expect(3, steepness_of(window.prior->width), 2 * window.prior->width_sigma * steepness_of(window.prior->width));
    return l;
}

/// Variance of the residuals about what is expected of a camera, each as important as its pixel is for the centre: a camera's noise
/// differs between dark and bright pixels from what was assumed, and the flanks decide. What the fit itself took away is put back.
std::optional<double> residual_noise(const Window& window, const SpotPixels& pixels, const Vector& p, const Matrix& covariance, const Response& response,
                                     const SpotFitSettings& s) {
    const SpotModel m = model_of(window, p, s);
    const double read = s.read_noise * s.read_noise + 1.0 / 12;
    double squares = 0;
    double expected = 0;
    for (int i = 0; i < pixels.count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const double x = static_cast<double>(pixels.x[k]);
        const double y = static_cast<double>(pixels.y[k]);
        const double dx = x - static_cast<double>(m.u);
        const double dy = y - static_cast<double>(m.v);
        const double square = dx * dx + dy * dy;
        const double light = std::exp(p[2] - p[3] * square);
        double by_light;
        const double model = response.grey(p[4] + p[5] * x + p[6] * y + light, by_light);
        const double seen = static_cast<double>(pixels.grey[k]);
        if (pixels.weight[k] == 0 || (seen >= s.saturated && model >= s.saturated)) continue;
        const double residual = std::min<double>(seen, s.saturated) - model;
        const double variance = read + s.shot_noise * model;
        const double z = std::abs(residual) / std::sqrt(variance);
        const double weight = (z > static_cast<double>(huber) ? static_cast<double>(huber) / z : 1) / variance;
        const double slope = 2 * by_light * light * p[3];
        const Vector d = (Vector() << slope * dx, slope * dy, by_light * light, -by_light * light * square, by_light, by_light * x, by_light * y).finished();
        const double importance = weight * (d[0] * d[0] + d[1] * d[1]);
        squares += importance * weight * residual * residual;
        expected += importance * (1 - weight * d.dot(covariance * d));
    }
    if (!(expected > 0)) return std::nullopt;
    return squares / expected;
}

/// The window's pixels within the reach of its middle.
void gather(const Window& window, SpotPixels& pixels) {
    int count = 0;
    const auto add = [&](double x, double y, float grey, float weight) {
        const auto k = static_cast<std::size_t>(count++);
        pixels.x[k] = static_cast<float>(x);
        pixels.y[k] = static_cast<float>(y);
        pixels.grey[k] = grey;
        pixels.weight[k] = weight;
    };
    for (int j = 0; j < window.size; ++j) {
        for (int i = 0; i < window.size; ++i) {
            const Eigen::Vector2d place(window.left + i, window.top + j);
            if ((place - window.middle).squaredNorm() > window.reach_squared) continue;
            add(place.x() - window.centre_x(), place.y() - window.centre_y(), window.pixels[j * window.stride + i], 1);
        }
    }
    while (count % 16 != 0) add(0, 0, 0, 0);
    pixels.count = count;
}

/// Median of the window's rim: a neighbouring lamp on one side is not ground.
double rim_level(const Window& window) {
    std::array<std::uint8_t, 8 * largest_radius> rim{};
    std::size_t count = 0;
    for (int i = 0; i < window.size - 1; ++i) {
        rim[count++] = window.pixels[i];
        rim[count++] = window.pixels[(window.size - 1) * window.stride + i + 1];
        rim[count++] = window.pixels[(i + 1) * window.stride];
        rim[count++] = window.pixels[i * window.stride + window.size - 1];
    }
    const auto end = rim.begin() + static_cast<std::ptrdiff_t>(count);
    const auto middle = rim.begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(rim.begin(), middle, end);
    return *middle;
}

/// The tables of a gamma are made once.
const Response& response_of(double gamma) {
    thread_local Response response(gamma);
    if (response.gamma() != gamma) response = Response(gamma);
    return response;
}

/// normal x = right by Cholesky, unrolled: Eigen's loops for seven unknowns take several times as long. False if it is not positive.
bool solve(Matrix normal, Vector right, Vector& x) {
    for (int j = 0; j < unknowns; ++j) {
        double pivot = normal(j, j);
        for (int k = 0; k < j; ++k) pivot -= normal(j, k) * normal(j, k);
        if (!(pivot > 0)) return false;
        const double inverse = 1 / std::sqrt(pivot);
        normal(j, j) = inverse;
        double sum = right[j];
        for (int k = 0; k < j; ++k) sum -= normal(j, k) * right[k];
        right[j] = sum * inverse;
        for (int i = j + 1; i < unknowns; ++i) {
            double value = normal(i, j);
            for (int k = 0; k < j; ++k) value -= normal(i, k) * normal(j, k);
            normal(i, j) = value * inverse;
        }
    }
    for (int j = unknowns - 1; j >= 0; --j) {
        double sum = right[j];
        for (int i = j + 1; i < unknowns; ++i) sum -= normal(i, j) * x[i];
        x[j] = sum * normal(j, j);
    }
    return x.allFinite();
}

/// Levenberg-Marquardt on the window; `p` is moved to the optimum.
std::optional<Linearised> converge(const Window& window, Vector& p, SpotPixels& pixels, const SpotFitSettings& settings) {
    gather(window, pixels);
    Linearised at = linearise(window, pixels, p, settings);
    double damping = 1e-3;
    for (int round = 0; round < settings.rounds; ++round) {
        Matrix normal = at.normal;
        normal.diagonal() *= 1 + damping;
        normal.diagonal() += 1e-12 * at.normal.diagonal().maxCoeff() * Vector::Ones();
        Vector step;
        if (!solve(normal, at.gradient, step)) return std::nullopt;
        Vector next = p + step;
        next[3] = std::clamp(next[3], 0.4 * p[3], 2.5 * p[3]);
        next[3] = std::clamp(next[3], steepness_of(settings.radius), steepness_of(0.3));
        next[2] = std::clamp(next[2], p[2] - 2, p[2] + 2);
        // The ground shines nowhere in the window with less than nothing, where the response curve is steepest.
        next[4] = std::max(next[4], 0.3 * p[4]);
        const double steepest = 0.6 * next[4] / settings.radius;
        for (int i = 5; i < unknowns; ++i) next[i] = std::clamp(next[i], -steepest, steepest);
        const Linearised moved = linearise(window, pixels, next, settings);
        // A step that no longer changes anything, up or down, ends it.
        const bool settled = std::abs(at.cost - moved.cost) < 0.1 && step.head<2>().norm() < 2e-3;
        // Saturated pixels leave the sum when the model exceeds them, so costs are comparable.
        if (moved.cost <= at.cost * (1 + 1e-9) + 1e-9) {
            p = next;
            at = moved;
            damping *= 0.1;
        } else {
            damping *= 10;
        }
        if (settled) break;
    }
    return at;
}

std::optional<Window> window_at(LumaView frame, const Eigen::Vector2d& centre, int radius) {
    const int x = static_cast<int>(std::lround(centre.x())) - radius;
    const int y = static_cast<int>(std::lround(centre.y())) - radius;
    const int size = 2 * radius + 1;
    if (x < 0 || y < 0 || x + size > frame.width || y + size > frame.height) return std::nullopt;
    return Window{frame.row(y) + x, frame.stride, size, static_cast<double>(x), static_cast<double>(y)};
}

}  // namespace

std::optional<Eigen::Vector2d> spot_centroid(LumaView frame, const Eigen::Vector2d& near, int radius) {
    Eigen::Vector2d centre = near;
    for (int round = 0; round < 2; ++round) {
        const auto window = window_at(frame, centre, radius);
        if (!window) return std::nullopt;
        const double ground = rim_level(*window);
        double sum = 0;
        Eigen::Vector2d moment = Eigen::Vector2d::Zero();
        for (int j = 0; j < window->size; ++j) {
            for (int i = 0; i < window->size; ++i) {
                const double light = std::max(window->pixels[j * window->stride + i] - ground - 20, 0.0);
                sum += light;
                moment += light * Eigen::Vector2d(window->left + i, window->top + j);
            }
        }
        if (!(sum > 0)) return std::nullopt;
        centre = moment / sum;
    }
    return centre;
}

std::optional<SpotFit> fit_spot(LumaView frame, const Eigen::Vector2d& start, const SpotFitSettings& settings, const SpotPrior* prior) {
    auto window = window_at(frame, start, settings.radius);
    if (!window || settings.radius > largest_radius) return std::nullopt;
    Vector p;
    const double ground = rim_level(*window);
    double brightest = 0;
    for (int j = 0; j < window->size; ++j) {
        for (int i = 0; i < window->size; ++i) brightest = std::max<double>(brightest, window->pixels[j * window->stride + i]);
    }
    if (brightest < ground + 10) return std::nullopt;
    const Response& response = response_of(settings.gamma);
    const double ground_light = std::max(response.light(ground), 1e-4);
    const double half_light = 0.5 * (response.light(brightest) + ground_light);
    int above_half = 0;
    for (int j = 0; j < window->size; ++j) {
        for (int i = 0; i < window->size; ++i) above_half += response.light(window->pixels[j * window->stride + i]) > half_light;
    }
    // The area above half of a Gaussian is 2 pi ln 2 width^2; a saturated one is higher than it looks, and narrower.
    const bool cut_off = brightest >= settings.saturated;
    const double width = std::clamp(std::sqrt(above_half / 4.36) * (cut_off ? 0.8 : 1), 0.5, 3.0);
    p << start.x(), start.y(), std::log(std::max(response.light(brightest) - ground_light, 1e-3) * (cut_off ? 1.6 : 1.1)), steepness_of(width), ground_light, 0,
        0;

    if (prior) {
        window->prior = prior;
        p[2] = std::log(prior->amplitude);
        p[3] = steepness_of(prior->width);
    }
    // Beyond, the spot's own light is gone and only what lies beside it is left, the panel's edge for one. A window that is not
    // centred on the spot pulls it: the second fit is.
    const double reach = std::max(settings.reach * (prior ? prior->width : width), 2.2);
    window->middle = start;
    window->reach_squared = reach * reach;
    SpotPixels pixels;
    auto at = converge(*window, p, pixels, settings);
    if (!at) return std::nullopt;
    if ((p.head<2>() - window->middle).norm() > off_centre) {
        window->middle = p.head<2>();
        at = converge(*window, p, pixels, settings);
        if (!at) return std::nullopt;
    }

    SpotFit fit;
    fit.centre = p.head<2>();
    const double half = settings.radius;
    const Eigen::Vector2d off = fit.centre - Eigen::Vector2d(window->left + half, window->top + half);
    if (!(off.cwiseAbs().maxCoeff() < 0.5 * half) || !std::isfinite(p[2])) return std::nullopt;
    const Eigen::LLT<Matrix> factor(at->normal);
    if (factor.info() != Eigen::Success) return std::nullopt;
    const Matrix covariance = factor.solve(Matrix::Identity());
    fit.covariance = covariance.topLeftCorner<2, 2>();
    const auto noise = residual_noise(*window, pixels, p, covariance, response, settings);
    if (!noise) return std::nullopt;
    fit.noise = *noise;
    fit.amplitude = std::exp(p[2]);
    fit.width = std::sqrt(0.5 / p[3]);
    fit.ground = ground;
    double slope;
    fit.peak = response.grey(std::min(p[4] + fit.amplitude, 1.0), slope);
    return fit;
}

}  // namespace roomfix
