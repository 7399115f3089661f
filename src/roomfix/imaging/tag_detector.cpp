#include "roomfix/imaging/tag_detector.hpp"

#include <cstdlib>

extern "C" {
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
}

namespace roomfix {

struct TagDetector::Impl {
    apriltag_family_t* family = tag36h11_create();
    apriltag_detector_t* detector = apriltag_detector_create();
    ~Impl() {
        apriltag_detector_destroy(detector);
        tag36h11_destroy(family);
    }
};

TagDetector::TagDetector(const TagDetectorSettings& settings) : impl_(std::make_unique<Impl>()), settings_(settings) {
    apriltag_detector_add_family_bits(impl_->detector, impl_->family, settings.most_corrected);
    impl_->detector->quad_decimate = settings.decimation;
    impl_->detector->nthreads = 1;
}

TagDetector::~TagDetector() = default;
TagDetector::TagDetector(TagDetector&&) noexcept = default;
TagDetector& TagDetector::operator=(TagDetector&&) noexcept = default;

void TagDetector::detect(LumaView frame, std::vector<SeenTag>& tags) {
    tags.clear();
    // The library only reads the picture; its structure has no const.
    image_u8_t picture{frame.width, frame.height, static_cast<std::int32_t>(frame.stride), const_cast<std::uint8_t*>(frame.data)};
    zarray_t* found = apriltag_detector_detect(impl_->detector, &picture);
    for (int i = 0; i < zarray_size(found); ++i) {
        apriltag_detection_t* detection = nullptr;
        zarray_get(found, i, &detection);
        if (static_cast<double>(detection->decision_margin) < settings_.least_margin) continue;
        SeenTag tag;
        tag.number = detection->id;
        for (std::size_t k = 0; k < 4; ++k) {
            // The library's pixels have their corner, not their centre, at whole numbers.
            tag.corners[k] = Eigen::Vector2d(detection->p[k][0] - 0.5, detection->p[k][1] - 0.5);
        }
        tags.push_back(tag);
    }
    apriltag_detections_destroy(found);
}

LumaImage tag_picture(int number) {
    apriltag_family_t* family = tag36h11_create();
    image_u8_t* picture = apriltag_to_image(family, number);
    LumaImage image(picture->width, picture->height);
    for (int y = 0; y < picture->height; ++y) std::memcpy(image.row(y), picture->buf + y * picture->stride, static_cast<std::size_t>(picture->width));
    std::free(picture->buf);  // image_u8_destroy() is not exported
    std::free(picture);
    tag36h11_destroy(family);
    return image;
}

}  // namespace roomfix
