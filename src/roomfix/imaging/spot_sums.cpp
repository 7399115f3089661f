#include "roomfix/imaging/spot_sums.hpp"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "roomfix/imaging/spot_sums.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// Needs highway.h before it.
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace roomfix {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// At most 16 lanes: the pixels are padded to that.
using Floats = hn::CappedTag<float, 16>;

void SpotSumsOf(const SpotPixels& pixels, const SpotModel& model, SpotSums& sums) {
    const Floats f;
    using V = hn::Vec<Floats>;
    const int lanes = static_cast<int>(hn::Lanes(f));
    const auto all = [&](float value) { return hn::Set(f, value); };
    std::array<V, 36> total;
    for (V& t : total) t = hn::Zero(f);
    for (int i = 0; i < pixels.count; i += lanes) {
        const V x = hn::Load(f, pixels.x.data() + i);
        const V y = hn::Load(f, pixels.y.data() + i);
        const V seen = hn::Load(f, pixels.grey.data() + i);
        const V valid = hn::Load(f, pixels.weight.data() + i);
        const V dx = hn::Sub(x, all(model.u));
        const V dy = hn::Sub(y, all(model.v));
        const V square = hn::MulAdd(dx, dx, hn::Mul(dy, dy));
        const V light = hn::Mul(all(model.amplitude), hn::Exp(f, hn::Neg(hn::Min(hn::Mul(all(model.steepness), square), all(80.0f)))));
        const V ground = hn::MulAdd(all(model.slope_x), x, hn::MulAdd(all(model.slope_y), y, all(model.ground)));
        const V all_light = hn::Min(hn::Max(hn::Add(ground, light), all(1e-6f)), all(1.0f));
        const V grey = hn::Mul(all(255.0f), hn::Exp(f, hn::Mul(hn::Log(f, all_light), all(1 / model.gamma))));
        const V by_light = hn::Div(hn::Mul(grey, all(1 / model.gamma)), all_light);
        // A saturated pixel says something only where the model stays below it.
        const V limit = all(model.saturated);
        const auto silent = hn::And(hn::Ge(seen, limit), hn::Ge(grey, limit));
        const V residual = hn::Sub(hn::Min(seen, limit), grey);
        const V real = hn::IfThenElse(hn::Lt(seen, limit), hn::Sub(seen, grey), residual);
        const V variance = hn::MulAdd(all(model.shot_noise), grey, all(model.read_variance));
        const V z = hn::Div(hn::Abs(real), hn::Sqrt(variance));
        const auto far = hn::Gt(z, all(model.huber));
        const V counts = hn::IfThenZeroElse(silent, valid);
        const V weight = hn::Mul(counts, hn::Div(hn::IfThenElse(far, hn::Div(all(model.huber), z), all(1.0f)), variance));
        const V cost = hn::IfThenElse(far, hn::Mul(all(model.huber), hn::Sub(hn::Add(z, z), all(model.huber))), hn::Mul(z, z));
        const V spot = hn::Mul(by_light, light);
        const V steep = hn::Mul(all(2 * model.steepness), spot);
        const std::array<V, 7> d = {hn::Mul(steep, dx),   hn::Mul(steep, dy),  spot, hn::Neg(hn::Mul(spot, square)), by_light,
                                    hn::Mul(by_light, x), hn::Mul(by_light, y)};
        std::size_t k = 0;
        for (std::size_t a = 0; a < 7; ++a) {
            const V weighted = hn::Mul(weight, d[a]);
            for (std::size_t b = 0; b <= a; ++b, ++k) total[k] = hn::MulAdd(weighted, d[b], total[k]);
            total[28 + a] = hn::MulAdd(weighted, real, total[28 + a]);
        }
        total[35] = hn::MulAdd(counts, cost, total[35]);
    }
    for (std::size_t k = 0; k < 28; ++k) sums.normal[k] = hn::GetLane(hn::SumOfLanes(f, total[k]));
    for (std::size_t a = 0; a < 7; ++a) sums.gradient[a] = hn::GetLane(hn::SumOfLanes(f, total[28 + a]));
    sums.cost = hn::GetLane(hn::SumOfLanes(f, total[35]));
}

}  // namespace HWY_NAMESPACE
}  // namespace roomfix
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace roomfix {

HWY_EXPORT(SpotSumsOf);

void simd::spot_sums(const SpotPixels& pixels, const SpotModel& model, SpotSums& sums) { HWY_DYNAMIC_DISPATCH(SpotSumsOf)(pixels, model, sums); }

void scalar::spot_sums(const SpotPixels& pixels, const SpotModel& model, SpotSums& sums) {
    sums = {};
    for (int i = 0; i < pixels.count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const float dx = pixels.x[k] - model.u;
        const float dy = pixels.y[k] - model.v;
        const float square = dx * dx + dy * dy;
        const float light = model.amplitude * std::exp(-std::min(model.steepness * square, 80.0f));
        const float all_light = std::clamp(model.ground + model.slope_x * pixels.x[k] + model.slope_y * pixels.y[k] + light, 1e-6f, 1.0f);
        const float grey = 255 * std::pow(all_light, 1 / model.gamma);
        const float by_light = grey / (model.gamma * all_light);
        const bool saturated = pixels.grey[k] >= model.saturated;
        if ((saturated && grey >= model.saturated) || pixels.weight[k] == 0) continue;
        const float residual = std::min(pixels.grey[k], model.saturated) - grey;
        const float variance = model.read_variance + model.shot_noise * grey;
        const float z = std::abs(residual) / std::sqrt(variance);
        const float weight = (z > model.huber ? model.huber / z : 1) / variance;
        sums.cost += z > model.huber ? model.huber * (2 * z - model.huber) : z * z;
        const float spot = by_light * light;
        const float steep = 2 * model.steepness * spot;
        const std::array<float, 7> d = {steep * dx, steep * dy, spot, -spot * square, by_light, by_light * pixels.x[k], by_light * pixels.y[k]};
        std::size_t n = 0;
        for (std::size_t a = 0; a < 7; ++a) {
            for (std::size_t b = 0; b <= a; ++b) sums.normal[n++] += weight * d[a] * d[b];
            sums.gradient[a] += weight * d[a] * residual;
        }
    }
}

}  // namespace roomfix
#endif
