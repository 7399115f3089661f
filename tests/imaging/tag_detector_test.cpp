// Square tags of every family, from all four sides.
#include "roomfix/imaging/tag_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace roomfix {
namespace {

constexpr int margin = 24;  // px around a tag

/// A tag on light grey, `scale` px per bit, its picture turned clockwise by `quarters`.
LumaImage turned_picture(const TagPicture& tag, int scale, int quarters) {
    const int bits = tag.bits.width();
    const int size = scale * bits + 2 * margin;
    cv::Mat picture(size, size, CV_8U, cv::Scalar(200));
    for (int y = 0; y < scale * bits; ++y) {
        for (int x = 0; x < scale * bits; ++x) picture.at<std::uint8_t>(y + margin, x + margin) = tag.bits.row(y / scale)[x / scale];
    }
    for (int i = 0; i < quarters; ++i) cv::rotate(picture, picture, cv::ROTATE_90_CLOCKWISE);
    LumaImage image(size, size);
    for (int y = 0; y < size; ++y) std::copy_n(picture.ptr(y), size, image.row(y));
    return image;
}

/// ArUco's original dictionary has tags that look the same upside down.
bool same_upside_down(const LumaImage& bits) {
    for (int y = 0; y < bits.height(); ++y) {
        for (int x = 0; x < bits.width(); ++x) {
            if (bits.row(y)[x] != bits.row(bits.height() - 1 - y)[bits.width() - 1 - x]) return false;
        }
    }
    return true;
}

TEST(TagDetector, ReadsEveryFamilyFromAllSides) {
    constexpr int scale = 12;
    int read = 0;
    for (const std::string& name : tag_family_names()) {
        const TagFamily family = *tag_family_named(name);
        if (!can_read(family)) continue;
        ++read;
        TagDetector detector({family});
        for (const int number : {0, 1, tag_count(family) / 2, tag_count(family) - 1}) {
            const TagPicture tag = tag_picture(family, number);
            const double half = 0.5 * scale * tag.square;
            for (int quarters = 0; quarters < 4; ++quarters) {
                const LumaImage image = turned_picture(tag, scale, quarters);
                std::vector<SeenTag> seen;
                detector.detect(image, seen);
                ASSERT_EQ(seen.size(), 1U) << name << " " << number << " turned by " << quarters;
                EXPECT_EQ(seen[0].family, family);
                EXPECT_EQ(seen[0].number, number) << name << " turned by " << quarters;
                if (same_upside_down(tag.bits)) continue;
                // Bottom left of the tag as it is read; turned clockwise it goes to the top left, ...
                Eigen::Vector2d corner(-half, half);
                for (int i = 0; i < quarters; ++i) corner = Eigen::Vector2d(-corner.y(), corner.x());
                const double middle = 0.5 * (image.width() - 1);
                EXPECT_LT((seen[0].corners[0] - Eigen::Vector2d(middle, middle) - corner).norm(), 0.5) << name << " " << number << " turned by " << quarters;
            }
        }
    }
    EXPECT_GE(read, 9);
}

TEST(TagDetector, TellsFamiliesApartInOnePicture) {
    std::vector<TagFamily> families = {TagFamily::tag36h11, TagFamily::tag_standard41h12};
    if (can_read(TagFamily::aruco_5x5_250)) families.push_back(TagFamily::aruco_5x5_250);
    TagDetector detector(families);
    for (const TagFamily family : families) {
        std::vector<SeenTag> seen;
        detector.detect(turned_picture(tag_picture(family, 17), 10, 1), seen);
        ASSERT_EQ(seen.size(), 1U) << name_of(family);
        EXPECT_EQ(seen[0].family, family);
        EXPECT_EQ(seen[0].number, 17);
    }
    std::vector<SeenTag> seen;
    TagDetector({TagFamily::tag25h9}).detect(turned_picture(tag_picture(TagFamily::tag36h11, 17), 10, 0), seen);
    EXPECT_TRUE(seen.empty()) << "a family that nobody asked for";
}

TEST(TagFamily, HasANameAndIsFoundByIt) {
    for (const std::string& name : tag_family_names()) {
        const auto family = tag_family_named(name);
        ASSERT_TRUE(family) << name;
        EXPECT_EQ(name_of(*family), name);
        EXPECT_GT(tag_count(*family), 0);
    }
    EXPECT_FALSE(tag_family_named("tag36H11"));
    EXPECT_FALSE(tag_family_named(""));
}

}  // namespace
}  // namespace roomfix
