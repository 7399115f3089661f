#include "roomfix/connect/plan_picture.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "roomfix/base/text_file.hpp"
#include "roomfix/site/read_plan.hpp"

namespace roomfix {
namespace {

/// Dark becomes light, what is transparent stays so.
void turn_over(cv::Mat& picture) {
    std::vector<cv::Mat> channels(static_cast<std::size_t>(picture.channels()));
    for (int c = 0; c < picture.channels(); ++c) cv::extractChannel(picture, channels[static_cast<std::size_t>(c)], c);
    const double white = picture.depth() == CV_16U ? 65535 : 255;
    for (std::size_t c = 0; c < channels.size() && c < 3; ++c) channels[c] = white - channels[c];
    cv::merge(channels, picture);
}

cv::Mat decoded(const std::string& bytes) {
    try {
        return cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data())), cv::IMREAD_UNCHANGED);
    } catch (const cv::Exception&) {
        return {};
    }
}

}  // namespace

Result<PlanPicture> load_plan_picture(const Site& site, const SitePlan& plan) {
    std::filesystem::path file = resolved_path(site, plan.image);
    bool negate = false;
    if (is_map_file(plan.image)) {
        const auto map = load_map_file(file);
        if (!map) return map.error();
        file = file.parent_path() / map->image;
        negate = map->negate;
    }
    if (const auto fine = check_plan_picture(file); !fine) return fine.error();
    auto bytes = read_text(file);
    if (!bytes) return bytes.error();
    cv::Mat picture = decoded(*bytes);
    if (picture.empty()) return Error{file.string() + ": is damaged: write the plan's picture again"};
    PlanPicture result{picture.cols, picture.rows, {}};
    const bool png = bytes->starts_with("\x89PNG");
    if (png && !negate) {
        result.png = std::move(*bytes);
        return result;
    }
    if (negate) turn_over(picture);
    std::vector<unsigned char> encoded;
    if (!cv::imencode(".png", picture, encoded)) return Error{file.string() + ": cannot be made a PNG"};
    result.png.assign(encoded.begin(), encoded.end());
    return result;
}

}  // namespace roomfix
