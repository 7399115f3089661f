#include "roomfix/corner/edge_step.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roomfix {
namespace {

/// The step Phi(z) and the bell phi(z), tabulated.
struct StepShape {
    static constexpr int per_unit = 64;
    static constexpr int reach = 6;
    std::array<float, 2 * reach * per_unit + 1> step, bell;

    StepShape() {
        for (int i = 0; i < static_cast<int>(step.size()); ++i) {
            const double z = static_cast<double>(i - reach * per_unit) / per_unit;
            step[static_cast<std::size_t>(i)] = static_cast<float>(0.5 * std::erfc(-z / std::numbers::sqrt2));
            bell[static_cast<std::size_t>(i)] = static_cast<float>(std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi));
        }
    }
    std::size_t at(float z) const {
        const float place = std::clamp((z + reach) * per_unit + 0.5f, 0.0f, static_cast<float>(step.size() - 1));
        return static_cast<std::size_t>(place);
    }
};
const StepShape shape;

constexpr int phases = 8;    // of the line's place between two pixels
constexpr int columns = 48;  // across the line

/// Pixels across a line, summed over all rows (or columns) in which the line lies in the same eighth of a pixel.
struct PhaseSums {
    std::array<std::array<std::uint16_t, columns>, phases> grey{};
    std::array<std::uint16_t, phases> rows{};
    std::array<float, phases> place{};  // sum over the rows of the line's place from the first pixel, px
};

constexpr int unknowns = 6;  // of fit_step()
using Square = Eigen::Matrix<double, unknowns, unknowns>;
using Row = Eigen::Matrix<double, unknowns, 1>;

/// Is this column of fit_step() an unknown of the model?
bool is_free(StepModel model, int column) {
    if (model == StepModel::crease) return column != 5;
    switch (column) {
        case 1:
            return model < StepModel::coarse;
        case 4:
            return model < StepModel::sloped;
        case 5:
            return model < StepModel::plain;
        default:
            return true;
    }
}
int count_free(StepModel model) {
    int count = 0;
    for (int i = 0; i < unknowns; ++i) count += is_free(model, i);
    return count;
}

/// A symmetric positive matrix as L D L^T; for so few unknowns plain loops cost less than a library's calls.
struct Factors {
    Square lower;  // unit diagonal, which is not stored
    Row inverse_pivots;

    /// Of the lower triangle of `matrix`; false if it is not positive.
    bool set(const Square& matrix) {
        Row scaled;  // of one row of L: times the pivots
        for (int i = 0; i < unknowns; ++i) {
            double pivot = matrix(i, i);
            for (int j = 0; j < i; ++j) {
                double value = matrix(i, j);
                for (int k = 0; k < j; ++k) value -= scaled[k] * lower(j, k);
                scaled[j] = value;
                lower(i, j) = value * inverse_pivots[j];
                pivot -= value * lower(i, j);
            }
            if (!(pivot > 0)) return false;
            inverse_pivots[i] = 1 / pivot;
        }
        return true;
    }
    Row solve(const Row& right) const {
        Row x = right;
        for (int i = 0; i < unknowns; ++i) {
            for (int j = 0; j < i; ++j) x[i] -= lower(i, j) * x[j];
        }
        for (int i = unknowns - 1; i >= 0; --i) {
            x[i] *= inverse_pivots[i];
            for (int j = i + 1; j < unknowns; ++j) x[i] -= lower(j, i) * x[j];
        }
        return x;
    }
    /// Entry k of the diagonal of the inverse.
    double inverse_entry(int k) const {
        Row column;
        double sum = 0;
        for (int i = k; i < unknowns; ++i) {
            double value = i == k ? 1 : 0;
            for (int j = k; j < i; ++j) value -= lower(i, j) * column[j];
            column[i] = value;
            sum += value * value * inverse_pivots[i];
        }
        return sum;
    }
};

}  // namespace

LightTable::LightTable(double gamma) {
    for (std::size_t i = 0; i < table_.size(); ++i) table_[i] = static_cast<float>(255 * std::pow(static_cast<double>(i) / 255, gamma));
}

bool read_profile(LumaView frame, const LightTable& light, const LineStretch& stretch, double reach, int skip, LightProfile& profile) {
    profile.values.clear();
    const Eigen::Vector2d step = stretch.to - stretch.from;
    const bool steep = std::abs(step.y()) > std::abs(step.x());
    // `a` runs along the picture's axis that is nearer to the line's direction, `b` across.
    const auto along = [&](const Eigen::Vector2d& p) { return steep ? p.y() : p.x(); };
    const auto across = [&](const Eigen::Vector2d& p) { return steep ? p.x() : p.y(); };
    if (!(std::abs(along(step)) > 1e-9)) return false;
    const double lean = across(stretch.normal());  // distance from the line per px across; its sign is the normal's
    const double slope = across(step) / along(step);
    const double half = std::min(reach, LightProfile::widest) / std::abs(lean);
    const int limit_along = steep ? frame.height : frame.width;
    const int limit_across = steep ? frame.width : frame.height;
    const double low = std::min(along(stretch.from), along(stretch.to));
    const double high = std::max(along(stretch.from), along(stretch.to));
    const int start = static_cast<int>(std::ceil(low));
    const int end = std::min(static_cast<int>(std::ceil(high)), start + 250 * skip);  // sums stay below 65536
    if (start < 0 || end > limit_along) return false;
    // Beside the picture's border less is read, but some of either side.
    const int lowest = static_cast<int>(std::floor(std::min(across(stretch.from), across(stretch.to)))) - 1;
    const int highest = static_cast<int>(std::floor(std::max(across(stretch.from), across(stretch.to)))) + 1;
    const int first_column = std::max(-static_cast<int>(half), -lowest);
    const int last_column = std::min(static_cast<int>(half) + 1, limit_across - 1 - highest);
    const int width = std::min(last_column - first_column + 1, columns);
    constexpr int least_beside = 3;
    if (first_column > -least_beside || last_column < least_beside) return false;

    PhaseSums sums;
    double middle = across(stretch.from) + slope * (start - along(stretch.from));
    for (int a = start; a < end; a += skip, middle += slope * skip) {
        const int below = static_cast<int>(std::floor(middle));
        const int first = std::clamp(below + first_column, 0, limit_across - width);  // rounding
        const double part = middle - below;
        const auto phase = static_cast<std::size_t>(part * phases);
        std::uint16_t* grey = sums.grey[phase].data();
        ++sums.rows[phase];
        sums.place[phase] += static_cast<float>(part - first_column);
        if (steep) {
            const std::uint8_t* pixels = frame.row(a) + first;
            for (int i = 0; i < width; ++i) grey[i] = static_cast<std::uint16_t>(grey[i] + pixels[i]);
        } else {
            const std::uint8_t* pixel = frame.row(first) + a;
            for (int i = 0; i < width; ++i, pixel += frame.stride) grey[i] = static_cast<std::uint16_t>(grey[i] + *pixel);
        }
    }

    struct Bin {
        float count = 0, distance = 0, grey = 0;
    };
    constexpr int bins = LightProfile::most;
    std::array<Bin, bins> binned{};
    const float to_distance = static_cast<float>(lean);
    for (std::size_t phase = 0; phase < phases; ++phase) {
        if (sums.rows[phase] == 0) continue;
        const float rows = sums.rows[phase];
        float distance = -sums.place[phase] / rows * to_distance;
        for (int i = 0; i < width; ++i, distance += to_distance) {
            const int index = static_cast<int>(distance * static_cast<float>(1 / LightProfile::bin) + 0.5f * bins);
            if (index < 0 || index >= bins) continue;
            Bin& bin = binned[static_cast<std::size_t>(index)];
            bin.count += rows;
            bin.distance += rows * distance;
            bin.grey += sums.grey[phase][static_cast<std::size_t>(i)];
        }
    }
    for (const Bin& bin : binned) {
        if (bin.count > 0) profile.values.push_back({bin.distance / bin.count, light[bin.grey / bin.count], bin.count});
    }
    return true;
}

bool fit_step(const LightProfile& profile, double blur, double reach, StepModel model, EdgeStep& step) {
    // Columns: 1, distance, step, its change with the offset and with the blur, a change of slope; or 1, distance, crease, its change with the offset, a step,
    // a change of slope; last the light itself. Single precision is enough once the mean light is taken away, and the sums run over whole vectors of it.
    constexpr int columns_in_all = unknowns + 1;
    using Column = Eigen::Array<float, LightProfile::most, 1>;
    std::array<Column, columns_in_all> design;
    Column weight;
    const float inverse_blur = static_cast<float>(1 / blur);
    const float square_blur = static_cast<float>(blur * blur);
    const float limit = static_cast<float>(reach);
    const bool is_crease = model == StepModel::crease;
    const float bell_to_one = static_cast<float>(std::sqrt(2 * std::numbers::pi));
    int used = 0;
    float mean = 0;
    float total = 0;
    const auto step_columns = [&](float, float z, std::size_t i) {
        const float bell = shape.bell[i] * inverse_blur;
        design[2][used] = shape.step[i];
        design[3][used] = -bell;
        design[4][used] = -bell * z;
    };
    const auto crease_columns = [&](float d, float z, std::size_t i) {
        const float crease = shape.bell[i] * bell_to_one;
        design[2][used] = crease;
        design[3][used] = crease * z * inverse_blur;
        design[4][used] = shape.step[shape.at(d)];  // a step as sharp as lenses draw it
    };
    const auto fill = [&](const auto& columns_of_edge) {
        for (const LightAt& at : profile.values) {
            const float d = at.distance;
            if (std::abs(d) > limit) continue;
            const float z = d * inverse_blur;
            const std::size_t i = shape.at(z);
            design[0][used] = 1;
            design[1][used] = d;
            columns_of_edge(d, z, i);
            design[5][used] = d * shape.step[i] + shape.bell[i] * inverse_blur * square_blur;
            design[6][used] = at.light;
            weight[used] = at.count;
            mean += at.count * at.light;
            total += at.count;
            ++used;
        }
    };
    if (is_crease) {
        fill(crease_columns);
    } else {
        fill(step_columns);
    }
    const int free = count_free(model);
    if (used < free + 4) return false;
    mean /= total;
    design[6].head(used) -= mean;
    const int rows = (used + 7) / 8 * 8;
    for (Column& column : design) column.segment(used, rows - used).setZero();
    weight.segment(used, rows - used).setZero();
    // What the model leaves out has no say: a diagonal of one, and nothing beside it.
    Square normal = Square::Identity();
    Row right = Row::Zero();
    Column weighted;
    for (int i = 0; i < unknowns; ++i) {
        if (!is_free(model, i)) continue;
        weighted.head(rows) = weight.head(rows) * design[static_cast<std::size_t>(i)].head(rows);
        for (int j = i; j < unknowns; ++j) {
            if (!is_free(model, j)) continue;
            normal(j, i) = normal(i, j) = static_cast<double>((weighted.head(rows) * design[static_cast<std::size_t>(j)].head(rows)).sum());
        }
        normal(i, i) += 1e-6;
        right[i] = static_cast<double>((weighted.head(rows) * design[unknowns].head(rows)).sum());
    }
    const double squares = static_cast<double>((weight.head(rows) * design[unknowns].head(rows).square()).sum());
    Factors factors;
    if (!factors.set(normal)) return false;
    const Row fit = factors.solve(right);
    const double by_contrast = 1 / (fit[2] * fit[2]);
    step.noise = std::max(squares - fit.dot(right), 1e-4) / (used - free);
    step.contrast = fit[2];
    step.contrast_sigma = std::sqrt(step.noise * factors.inverse_entry(2));
    step.offset = fit[3] / fit[2];
    step.variance = step.noise * factors.inverse_entry(3) * by_contrast;
    step.blur = is_crease ? blur : blur + fit[4] / fit[2];
    step.blur_variance = step.noise * factors.inverse_entry(4) * by_contrast;
    return std::isfinite(step.offset) && std::isfinite(step.variance) && step.variance > 0;
}

}  // namespace roomfix
