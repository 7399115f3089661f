#include "roomfix/overhead/left_over.hpp"

#include <algorithm>

#include "roomfix/overhead/floor_shadows.hpp"

namespace roomfix {
namespace {

/// Visits the numbers of a mask's pixels in a picture of this width.
template <class Visit>
void for_each_pixel(const BodyMask& mask, int width, Visit&& visit) {
    for (const Span& span : mask.spans) {
        for (int x = span.begin; x < span.end; ++x) visit(span.y * width + x);
    }
}

}  // namespace

void LeftOver::begin(std::span<const SeenBy> cameras) {
    left_.resize(cameras.size());
    on_trial_.resize(cameras.size());
    moment_.assign(cameras.begin(), cameras.end());
    for (std::size_t c = 0; c < cameras.size(); ++c) {
        left_[c].copy_pixels(*cameras[c].evidence);
        moment_[c].evidence = &left_[c];
    }
    if (cameras.size() > 1) weigh_shadows(cameras, left_);
    for (Evidence& evidence : left_) evidence.sum_up();
}

/// Fills `covered_` with the pixels that a body covers in a camera's picture; false where nobody can tell.
bool LeftOver::list_pixels(const SeenBy& camera, const StandingBody& taken) {
    const Evidence& evidence = *camera.evidence;
    cover(*camera.view, taken.body->parts, taken.pose, evidence.width, evidence.height, evidence.scale, 1, mask_);
    if (!mask_.valid) return false;
    covered_.clear();
    for_each_pixel(mask_, evidence.width, [&](int pixel) { covered_.push_back(pixel); });
    return true;
}

/// What other bodies cover, beside the pixels that are `covered_`, is no shadow of this one: it is set aside.
void LeftOver::spare(std::size_t camera, std::span<const StandingBody> others) {
    Evidence& evidence = left_[camera];
    spared_.clear();
    if (others.empty()) return;
    std::sort(covered_.begin(), covered_.end());
    for (const StandingBody& other : others) {
        cover(*moment_[camera].view, other.body->parts, other.pose, evidence.width, evidence.height, evidence.scale, 1, mask_);
        if (!mask_.valid) continue;
        for_each_pixel(mask_, evidence.width, [&](int number) {
            const auto pixel = static_cast<std::size_t>(number);
            if (evidence.perhaps[pixel] <= 0 || std::binary_search(covered_.begin(), covered_.end(), number)) return;
            spared_.emplace_back(pixel, evidence.perhaps[pixel]);
            evidence.perhaps[pixel] = 0;
        });
    }
}

void LeftOver::take_away(std::size_t camera, const StandingBody& taken, std::span<const StandingBody> others, Changes* before) {
    if (before) before->clear();
    if (!list_pixels(moment_[camera], taken)) return;
    spare(camera, others);
    left_[camera].take_away(covered_, before);
    for (const auto& [pixel, shadow] : spared_) left_[camera].perhaps[pixel] = shadow;
}

void LeftOver::take_away(const StandingBody& taken, std::span<const StandingBody> others) {
    for (std::size_t c = 0; c < moment_.size(); ++c) take_away(c, taken, others, nullptr);
}

void LeftOver::try_away(const StandingBody& taken, std::span<const StandingBody> others) {
    for (std::size_t c = 0; c < moment_.size(); ++c) take_away(c, taken, others, &on_trial_[c]);
}

void LeftOver::put_back() {
    for (std::size_t c = 0; c < moment_.size(); ++c) left_[c].put_back(on_trial_[c]);
}

}  // namespace roomfix
