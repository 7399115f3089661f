#include "roomfix/imaging/picture_alignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "roomfix/base/random.hpp"
#include "roomfix/geometry/pose.hpp"
#include "roomfix/imaging/picture_stabiliser.hpp"

namespace roomfix {
namespace {

const CameraModel wide = make_camera_model(320, 240, 210, 212.5, 161, 118.5, {-0.2, 0.05, 0.0004, -0.0003, 0});

/// A wall far away with patches of many sizes on it, and things that stand before it.
struct World {
    struct Patch {
        Eigen::Vector2d middle, half, along;
        double level;

        bool covers(const Eigen::Vector2d& at) const {
            const Eigen::Vector2d off = at - middle;
            return std::abs(along.dot(off)) < half.x() && std::abs(along.x() * off.y() - along.y() * off.x()) < half.y();
        }
    };
    std::vector<Patch> patches, things;
    double ground = 100;

    explicit World(Random& random) {
        ground = random.uniform(40, 180);
        for (int i = 0; i < 40; ++i) patches.push_back(random_patch(random, 0.02, 0.25));
    }
    static Patch random_patch(Random& random, double least, double most) {
        const double angle = random.uniform(0, 3);
        return {{random.uniform(-0.9, 0.9), random.uniform(-0.7, 0.7)},
                {random.uniform(least, most), random.uniform(least, most)},
                {std::cos(angle), std::sin(angle)},
                random.uniform(15, 235)};
    }
    double level(const Eigen::Vector2d& ray) const {
        for (auto patch = patches.rbegin(); patch != patches.rend(); ++patch) {
            if (patch->covers(ray)) return patch->level;
        }
        return ground;
    }
};

/// Rays through two points of every pixel, which is no point itself.
const std::vector<std::array<Eigen::Vector2d, 2>>& all_rays() {
    static const auto rays = [] {
        std::vector<std::array<Eigen::Vector2d, 2>> of_pixels;
        for (int y = 0; y < wide.height; ++y) {
            for (int x = 0; x < wide.width; ++x) of_pixels.push_back({*unproject(wide, {x - 0.25, y + 0.25}), *unproject(wide, {x + 0.25, y - 0.25})});
        }
        return of_pixels;
    }();
    return rays;
}

/// What a camera sees that was turned like that, in another light. Things keep their places in the picture: they are no landmarks.
LumaImage picture_of(const World& world, const PictureMotion& motion, double light, double noise, Random& random) {
    LumaImage image(wide.width, wide.height);
    const Eigen::Matrix3d turn = exponential_rotation(motion.head<3>());
    auto rays = all_rays().begin();
    for (int y = 0; y < wide.height; ++y) {
        for (int x = 0; x < wide.width; ++x, ++rays) {
            double sum = 0;
            for (const Eigen::Vector2d& ray : *rays) {
                const auto thing = std::find_if(world.things.begin(), world.things.end(), [&](const World::Patch& t) { return t.covers(ray); });
                const Eigen::Vector3d before = turn * Eigen::Vector3d(ray.x(), ray.y(), 1);
                sum += 0.5 * (thing != world.things.end() ? thing->level : light * world.level(before.head<2>() / before.z()));
            }
            image.row(y)[x] = static_cast<std::uint8_t>(std::clamp(sum + noise * random.normal() + 0.5, 0.0, 255.0));
        }
    }
    return image;
}

PictureMotion random_motion(Random& random, double most_degrees) {
    PictureMotion motion = PictureMotion::Zero();
    motion.head<3>() = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized() * radians(random.uniform(0.1, most_degrees));
    return motion;
}

/// px, the largest over the picture.
double apart(const PictureMotion& a, const PictureMotion& b) {
    double most = 0;
    for (int y = 20; y < wide.height; y += 40) {
        for (int x = 20; x < wide.width; x += 40) {
            const Eigen::Vector2d ray = *unproject(wide, Eigen::Vector2d(x, y));
            most = std::max(most, (*seen_after(wide, ray, a) - *seen_after(wide, ray, b)).norm());
        }
    }
    return most;
}

TEST(PictureAlignment, FindsHowACameraWasTurnedBehindThingsAndInOtherLight) {
    Random random(3);
    int right = 0;
    constexpr int worlds = 40;
    for (int i = 0; i < worlds; ++i) {
        World world(random);
        PictureAlignment alignment(wide);
        alignment.set_reference(picture_of(world, PictureMotion::Zero(), 1, 2, random));
        ASSERT_TRUE(alignment.has_reference());
        for (int k = 0; k < 6; ++k) world.things.push_back(World::random_patch(random, 0.05, 0.15));
        const PictureMotion motion = random_motion(random, i % 2 ? 1 : 5);
        const Alignment& found = alignment.align(picture_of(world, motion, random.uniform(0.6, 1.4), 3, random));
        right += found.nats > 14 && apart(found.motion, motion) < 0.5;
    }
    EXPECT_GE(right, worlds - 2);
}

TEST(PictureAlignment, ACameraThatStandsStillIsNotMoved) {
    Random random(5);
    for (int i = 0; i < 40; ++i) {
        World world(random);
        PictureStabiliser stabiliser(wide);
        const LumaImage empty = picture_of(world, PictureMotion::Zero(), 1, 2, random);
        stabiliser.set_reference(empty.view());
        for (int k = 0; k < 2 * (i % 8); ++k) world.things.push_back(World::random_patch(random, 0.05, 0.3));
        const LumaImage frame = picture_of(world, PictureMotion::Zero(), random.uniform(0.5, 1.5), 4, random);
        EXPECT_EQ(stabiliser.steady(frame).grey.data, frame.view().data) << "world " << i << ", off by " << stabiliser.offset() << " px";
        EXPECT_FALSE(stabiliser.moved());
    }
}

TEST(PictureAlignment, AnotherSceneIsNoMotion) {
    Random random(8);
    for (int i = 0; i < 20; ++i) {
        const World here(random), elsewhere(random);
        PictureStabiliser stabiliser(wide);
        stabiliser.set_reference(picture_of(here, PictureMotion::Zero(), 1, 2, random).view());
        const LumaImage frame = picture_of(elsewhere, PictureMotion::Zero(), 1, 2, random);
        EXPECT_EQ(stabiliser.steady(frame).grey.data, frame.view().data) << "world " << i << ", off by " << stabiliser.offset() << " px";
    }
}

TEST(PictureAlignment, AnEvenPictureIsNoReference) {
    LumaImage even(wide.width, wide.height);
    for (int y = 0; y < even.height(); ++y) std::fill_n(even.row(y), even.width(), std::uint8_t{90});
    PictureStabiliser stabiliser(wide);
    stabiliser.set_reference(even.view());
    EXPECT_FALSE(stabiliser.has_reference());
    EXPECT_EQ(stabiliser.steady(even).grey.data, even.view().data);
}

TEST(PictureStabiliser, TurnsGreyAndColourBackAndFillsWhatIsNotSeenFromTheReference) {
    Random random(11);
    const World world(random);
    const LumaImage empty = picture_of(world, PictureMotion::Zero(), 1, 1, random);
    ColourImage empty_colour;
    shrink_grey(empty, empty_colour);
    PictureStabiliser stabiliser(wide);
    stabiliser.set_reference({empty, &empty_colour});
    PictureMotion motion = PictureMotion::Zero();
    motion.head<3>() = Eigen::Vector3d(0.01, 0.02, -0.01);
    const LumaImage frame = picture_of(world, motion, 1, 1, random);
    ColourImage colour;
    shrink_grey(frame, colour);
    const PictureView steady = stabiliser.steady({frame, &colour}, 0);
    EXPECT_TRUE(stabiliser.moved());
    EXPECT_NEAR(stabiliser.turned(), motion.head<3>().norm(), radians(0.05));
    ASSERT_TRUE(steady.colour);
    double off = 0, before = 0, off_colour = 0;
    for (int y = 0; y < wide.height; ++y) {
        for (int x = 0; x < wide.width; ++x) {
            off += std::abs(steady.grey.at(x, y) - empty.view().at(x, y));
            before += std::abs(frame.view().at(x, y) - empty.view().at(x, y));
        }
    }
    for (std::size_t i = 0; i < empty_colour.values.size(); ++i) off_colour += std::abs(steady.colour->values[i] - empty_colour.values[i]);
    const double pixels = wide.width * wide.height;
    EXPECT_GT(before / pixels, 5);
    EXPECT_LT(off / pixels, 2);
    EXPECT_LT(off_colour / static_cast<double>(empty_colour.values.size()), 2);

    // Nobody looks again before some time has passed; then the camera is back.
    EXPECT_NE(stabiliser.steady(empty, 100'000'000).grey.data, empty.view().data);
    EXPECT_EQ(stabiliser.steady(empty, 400'000'000).grey.data, empty.view().data);
    EXPECT_FALSE(stabiliser.moved());
}

}  // namespace
}  // namespace roomfix
