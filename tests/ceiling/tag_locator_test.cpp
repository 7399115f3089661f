// A camera that stands anywhere and sees tags.
#include "roomfix/ceiling/tag_locator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/simulate/tag_scene.hpp"

namespace roomfix {
namespace {

/// A tag on a wall whose face looks towards +x.
SiteLandmark on_wall(int number, const Eigen::Vector3d& place, double size = 0.2) {
    SiteLandmark landmark{"t" + std::to_string(number), Tag{number, size}};
    landmark.map_from_landmark.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    landmark.map_from_landmark.translation() = place;
    landmark.sigma = 0.003;
    landmark.tilt_sigma = radians(0.4);
    return landmark;
}

/// A site as its file says, and as it really is.
struct Room {
    Site site;
    SiteCamera camera;
    std::vector<SiteLandmark> truly;

    explicit Room(std::vector<SiteLandmark> tags) : truly(tags) {
        site.landmarks = std::move(tags);
        camera.id = "eye";
        camera.model = {640, 480, 600, 600, 319.5, 239.5};
        camera.placement = KnownHeight{1.2, 2.0, ""};
    }
    LumaImage picture_from(const Eigen::Isometry3d& map_from_camera, std::uint64_t index) const {
        LumaImage frame(640, 480);
        for (int y = 0; y < 480; ++y) std::memset(frame.row(y), 120, 640);
        for (const SiteLandmark& tag : truly) {
            paint_tag({camera.model, {map_from_camera, Matrix6d::Zero()}}, tag.map_from_landmark, std::get<Tag>(tag.kind), 1.5,
                      index * 8 + static_cast<std::uint64_t>(std::get<Tag>(tag.kind).number), frame);
        }
        return frame;
    }
    /// Hangs each tag where a person with a tape may have hung it.
    void hang(Random& random) {
        for (std::size_t i = 0; i < truly.size(); ++i) {
            Vector6d off;
            for (int k = 0; k < 3; ++k) off[k] = random.normal(site.landmarks[i].sigma);
            for (int k = 3; k < 6; ++k) off[k] = random.normal(site.landmarks[i].tilt_sigma);
            truly[i].map_from_landmark = perturbed(site.landmarks[i].map_from_landmark, off);
        }
    }
    LocatedByTags locate(const LumaImage& frame) const {
        TagDetector detector(site.tag_families());
        std::vector<SeenTag> seen;
        detector.detect(frame, seen);
        LocatedByTags located;
        TagLocator(site, camera).locate(seen, located);
        return located;
    }
};

TEST(TagLocator, SixUnknownsAreAsWrongAsTheySay) {
    Room room({on_wall(3, {0, 0.4, 1.5}), on_wall(4, {0, -0.5, 1.1}, 0.3)});
    Random random(31);
    double sum = 0;
    constexpr int looks = 30;
    for (int i = 0; i < looks; ++i) {
        room.hang(random);
        const Eigen::Isometry3d truth = perturbed(looking_at({random.uniform(1.2, 2.4), random.uniform(-0.6, 0.6), random.uniform(0.8, 1.8)}, {0, 0, 1.3}),
                                                  (Vector6d() << 0, 0, 0, random.uniform(-0.2, 0.2), 0, 0).finished());
        const LocatedByTags located = room.locate(room.picture_from(truth, static_cast<std::uint64_t>(i)));
        ASSERT_FALSE(located.places.empty()) << i << ": " << located.reason;
        const UncertainPose3& found = located.places[0].map_from_camera;
        const Vector6d error = error_between(found.pose, truth);
        EXPECT_LT(error.head<3>().norm(), 0.08) << i;
        sum += error.dot(found.covariance.inverse() * error);
    }
    // Mean of 30 chi-squares of six: 6 +- 0.63.
    EXPECT_GT(sum / looks, 3.9);
    EXPECT_LT(sum / looks, 8.4);
}

TEST(TagLocator, AFlatTagFarAwayLeavesTwoPlaces) {
    const Room room({on_wall(3, {0, 0, 1.4}, 0.12)});
    // Nearly head-on: the tag tilts to one side or to the other by the same small angle.
    int both = 0, right_among = 0;
    constexpr int looks = 20;
    for (int i = 0; i < looks; ++i) {
        const Eigen::Isometry3d truth = looking_at({2.6, 0.35, 1.4}, {0, 0, 1.4});
        const LocatedByTags located = room.locate(room.picture_from(truth, static_cast<std::uint64_t>(100 + i)));
        ASSERT_FALSE(located.places.empty()) << located.reason;
        both += located.places.size() == 2;
        for (const TagCameraPlace& place : located.places) {
            const Vector6d error = error_between(place.map_from_camera.pose, truth);
            if (error.dot(place.map_from_camera.covariance.inverse() * error) < 22.5) {  // 99.9 %
                ++right_among;
                break;
            }
        }
    }
    EXPECT_GT(both, looks / 2);
    EXPECT_GE(right_among, looks - 1);
}

TEST(TagLocator, ATagThatHangsElsewhereIsLeftOut) {
    Room room({on_wall(3, {0, 0.4, 1.5}), on_wall(4, {0, -0.5, 1.1}, 0.3), on_wall(5, {0, 0, 1.6})});
    room.truly[0].map_from_landmark.translation().y() += 0.25;
    const Eigen::Isometry3d truth = looking_at({1.8, 0.1, 1.3}, {0, 0, 1.3});
    const LocatedByTags located = room.locate(room.picture_from(truth, 7));
    ASSERT_FALSE(located.places.empty());
    EXPECT_EQ(located.places[0].tags.size(), 2U);
    EXPECT_LT((located.places[0].map_from_camera.pose.translation() - truth.translation()).norm(), 0.04);
    EXPECT_GT(located.places[0].weight, 0.9);
}

TEST(TagLocator, SaysWhyThereIsNoPlace) {
    const Room room({on_wall(3, {0, 0, 1.4})});
    LumaImage grey(640, 480);
    EXPECT_EQ(room.locate(grey).reason, "no tag in the picture");
    LocatedByTags located;
    SeenTag unknown;
    unknown.number = 9;
    TagLocator(room.site, room.camera).locate({&unknown, 1}, located);
    EXPECT_EQ(located.reason, "the picture shows tags, but none that the site has");
    SeenTag broken;
    broken.number = 3;
    TagLocator(room.site, room.camera).locate({&broken, 1}, located);
    EXPECT_TRUE(located.places.empty()) << "all corners in one point";
}

}  // namespace
}  // namespace roomfix
