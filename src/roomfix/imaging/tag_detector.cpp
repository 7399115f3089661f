#include "roomfix/imaging/tag_detector.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "roomfix/imaging/tag_codes.hpp"

namespace roomfix {
namespace {

/// The chance that a square with random bits is read as one of a family's tags, with up to `corrected` bits wrong.
double chance_of_reading(const apriltag_family_t& family, int corrected) {
    double readings = 0;
    double ways = 1;  // to get so many bits wrong
    for (int wrong = 0; wrong <= corrected; ++wrong) {
        readings += ways;
        ways *= (family.nbits - static_cast<double>(wrong)) / (wrong + 1);
    }
    return 4 * family.ncodes * readings * std::pow(0.5, family.nbits);
}

/// As many as the settings allow, the family's distance between codes and the chance of false readings. The library keeps a table with all
/// that each code may be read as: of large families without errors only.
int corrected_bits(const apriltag_family_t& family, const TagDetectorSettings& settings) {
    constexpr double largest_table = 3e5;  // entries
    int corrected = std::clamp(settings.most_corrected, 0, (static_cast<int>(family.h) - 1) / 2);
    while (corrected > 0 && (chance_of_reading(family, corrected) > settings.largest_chance || family.ncodes * (1.0 + family.nbits) > largest_table))
        --corrected;
    return corrected;
}

}  // namespace

struct TagDetector::Impl {
    std::vector<std::pair<TagFamily, TagCodes>> families;
    apriltag_detector_t* detector = apriltag_detector_create();
    // The detector gives back what it keeps in the families: it goes first.
    ~Impl() { apriltag_detector_destroy(detector); }
};

TagDetector::TagDetector(const std::vector<TagFamily>& families, const TagDetectorSettings& settings) : impl_(std::make_unique<Impl>()), settings_(settings) {
    for (const TagFamily family : families) {
        if (auto codes = tag_codes(family)) impl_->families.emplace_back(family, std::move(codes));
    }
    for (const auto& [family, codes] : impl_->families) apriltag_detector_add_family_bits(impl_->detector, codes.get(), corrected_bits(*codes, settings));
    impl_->detector->quad_decimate = settings.decimation;
    impl_->detector->nthreads = 1;
}

TagDetector::~TagDetector() = default;
TagDetector::TagDetector(TagDetector&&) noexcept = default;
TagDetector& TagDetector::operator=(TagDetector&&) noexcept = default;

void TagDetector::detect(LumaView frame, std::vector<SeenTag>& tags) {
    tags.clear();
    if (impl_->families.empty()) return;
    // The library only reads the picture; its structure has no const.
    image_u8_t picture{frame.width, frame.height, static_cast<std::int32_t>(frame.stride), const_cast<std::uint8_t*>(frame.data)};
    zarray_t* found = apriltag_detector_detect(impl_->detector, &picture);
    for (int i = 0; i < zarray_size(found); ++i) {
        apriltag_detection_t* detection = nullptr;
        zarray_get(found, i, &detection);
        if (static_cast<double>(detection->decision_margin) < settings_.least_margin) continue;
        const auto of_it = [&](const auto& known) { return known.second.get() == detection->family; };
        SeenTag tag;
        tag.family = std::find_if(impl_->families.begin(), impl_->families.end(), of_it)->first;
        tag.number = detection->id;
        for (std::size_t k = 0; k < 4; ++k) {
            // The library's pixels have their corner, not their centre, at whole numbers.
            tag.corners[k] = Eigen::Vector2d(detection->p[k][0] - 0.5, detection->p[k][1] - 0.5);
        }
        tags.push_back(tag);
    }
    apriltag_detections_destroy(found);
}

bool can_read(TagFamily family) { return tag_codes(family) != nullptr; }

TagPicture tag_picture(TagFamily family, int number) {
    const TagCodes codes = tag_codes(family);
    image_u8_t* picture = apriltag_to_image(codes.get(), number);
    TagPicture printed{LumaImage(picture->width, picture->height), codes->width_at_border};
    for (int y = 0; y < picture->height; ++y) std::memcpy(printed.bits.row(y), picture->buf + y * picture->stride, static_cast<std::size_t>(picture->width));
    std::free(picture->buf);  // image_u8_destroy() is not exported
    std::free(picture);
    return printed;
}

}  // namespace roomfix
