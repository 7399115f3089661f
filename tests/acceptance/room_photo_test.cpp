// Ceiling corners of a real room, cut out of one photographed panorama. The figures stand in docs/chou1986.md.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>

#include "data_folder.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/geometry/pose.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/pipeline/camera/corner_camera.hpp"
#include "roomfix/site/load_site.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

TEST(RoomPhoto, CornersUnderAPlasterMouldingGiveTheCamerasPose) {
    const fs::path folder = data_folder("room-photo");
    if (!fs::exists(folder / "truth.csv")) GTEST_SKIP() << "no data in " << folder << ": set ROOMFIX_DATA";
    const auto site = load_site(folder / "site.yaml");
    ASSERT_TRUE(site) << site.error().message;
    auto camera = CornerCamera::create(*site, site->cameras[0]);
    ASSERT_TRUE(camera) << camera.error().message;
    int good_at_c0 = 0;
    std::vector<UncertainPose3> from_c2;
    for (const auto& fields : csv_rows(folder / "truth.csv")) {
        ASSERT_GE(fields.size(), 6u);
        const auto number = [&](std::size_t i) { return parse_number(fields[i]).value_or(0); };
        const Eigen::Quaterniond truth(number(5), number(2), number(3), number(4));
        const auto frame = load_luma(folder / fields[0]);
        ASSERT_TRUE(frame);
        FrameHints hints;
        for (std::size_t i = 0; i < site->corners.size(); ++i) {
            if (site->corners[i].id == fields[1]) hints.corner = static_cast<int>(i);
        }
        camera->look(*frame, hints);
        if (camera->located().places.empty()) {
            fmt::print("{}: {}\n", fields[0], camera->reason());
            continue;
        }
        const UncertainPose3& found = camera->located().places[0].map_from_camera;
        const Eigen::Isometry3d& pose = found.pose;
        const double distance = site->corners[static_cast<std::size_t>(hints.corner)].position.norm();
        const double off = pose.translation().norm() / distance;  // the camera is at the map's origin
        const double turned = degrees(Eigen::AngleAxisd(Eigen::Matrix3d(truth.normalized().toRotationMatrix().transpose() * pose.linear())).angle());
        fmt::print("{}: position off by {:.1f} % of the distance, rotation by {:.2f} deg\n", fields[0], 100 * off, turned);
        const bool good = off < 0.04 && turned < 1.5;
        good_at_c0 += fields[1] == "c0" && good;
        if (fields[1] == "c2") from_c2.push_back(found);
    }
    // docs/chou1986.md says what is missing to all eight within 4 % and 1.5 deg.
    EXPECT_EQ(good_at_c0, 4);
    // The walls' edge at c2 is a crease. All views are cut out of one photograph: they see one camera, wherever the annotation says it is.
    ASSERT_EQ(from_c2.size(), 4u);
    for (const UncertainPose3& one : from_c2) {
        // The plaster's edges beside the corner's may be a moulding on one wall only, and that is counted.
        EXPECT_LT(one.covariance.diagonal().head<3>().sum(), 0.7 * 0.7) << "ceiling heights squared";
        for (const UncertainPose3& other : from_c2) {
            const Eigen::Vector3d apart = one.pose.translation() - other.pose.translation();
            const Eigen::Matrix3d spread = (one.covariance + other.covariance).topLeftCorner<3, 3>();
            EXPECT_LT(apart.dot(spread.inverse() * apart), 11.34) << "as sure as they say: 99 % of chi-square, 3 unknowns";
        }
    }
}

}  // namespace
}  // namespace roomfix
