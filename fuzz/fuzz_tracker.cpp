// Any observations at any times: whatever the tracker and the smoother give out is finite and has a positive definite covariance.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/smooth/smoother.hpp"

namespace {

/// Numbers from the fuzzer's bytes: most of them plausible, some of any kind.
class Bytes {
public:
    Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
    bool empty() const { return at_ >= size_; }
    std::uint8_t byte() { return empty() ? 0 : data_[at_++]; }
    double number(double low, double high) {
        const std::uint8_t kind = byte();
        if (kind == 255) {
            double any = 0;
            std::uint8_t raw[sizeof any];
            for (auto& b : raw) b = byte();
            std::memcpy(&any, raw, sizeof any);
            return any;
        }
        return low + (high - low) * kind / 254.0;
    }

private:
    const std::uint8_t* data_;
    std::size_t size_;
    std::size_t at_ = 0;
};

roomfix::Site make_site() {
    using namespace roomfix;
    Site site;
    site.robots.resize(4);
    const char* ids[] = {"a", "b", "c", "many"};
    for (std::size_t i = 0; i < 4; ++i) {
        site.robots[i].id = ids[i];
        site.robots[i].shape = i < 2 ? Shape(Box{0.5, 0.4, 0.3}) : Shape(Cylinder{0.5, 0.1 * static_cast<double>(i)});
        site.robots[i].many = i == 3;
        site.robots[i].receivers = {Receiver{}};
        site.robots[i].receivers[0].bias_sigma = i == 2 ? 0.5 : 0;
        site.robots[i].receivers[0].scale_sigma = i == 2 ? 0.05 : 0;
    }
    for (std::size_t i = 0; i < 2; ++i) {
        site.robots[i].tag = Tag{static_cast<int>(i), 0.2};
        site.robots[i].robot_from_tag.translation() = Eigen::Vector3d(0, 0, 0.3);
    }
    SiteCamera camera;
    camera.id = "one";
    camera.model = make_camera_model(640, 480, 500, 500, 320, 240);
    KnownPose known;
    known.map_from_camera.pose = looking_at({4, -1, 3}, {4, 3, 0});
    known.map_from_camera.covariance = 1e-6 * Matrix6d::Identity();
    camera.placement.emplace<KnownPose>(known);
    camera.time_offset_sigma = 0.05;
    site.cameras.push_back(camera);
    site.robots[0].drive = Drive::differential;
    site.robots[2].drive = Drive::holonomic;
    site.beacons.resize(3);
    for (std::size_t i = 0; i < 3; ++i) site.beacons[i].position = Eigen::Vector3d(4.0 * static_cast<double>(i), 3.0 * static_cast<double>(i % 2), 2.5);
    return site;
}

void check(const roomfix::Fix& fix) {
    using namespace roomfix;
    if (fix.status == FixStatus::none) return;
    const bool finite = std::isfinite(fix.pose.x) && std::isfinite(fix.pose.y) && std::isfinite(fix.pose.yaw) && fix.covariance.allFinite();
    if (!finite || Eigen::LLT<Eigen::Matrix3d>(fix.covariance).info() != Eigen::Success) __builtin_trap();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace roomfix;
    static const Site site = make_site();
    if (size > 4000) return 0;
    Tracker tracker(site);
    tracker.keep_history();
    std::vector<Fix> given;
    Bytes bytes(data, size);
    Nanoseconds time = 1'000'000'000'000;
    while (!bytes.empty()) {
        const std::uint8_t what = bytes.byte();
        const double step = bytes.number(-0.5, 1.0);
        if (std::isfinite(step) && std::abs(step) < 1e6) time += from_seconds(step);
        const int robot = bytes.byte() % 6 - 1;
        switch (what % 6) {
            case 0: {
                std::vector<PoseObservation> frame(1 + bytes.byte() % 3);
                for (PoseObservation& o : frame) {
                    o.robot = robot;
                    o.pose = {bytes.number(0, 8), bytes.number(0, 6), bytes.number(-4, 4)};
                    o.covariance = Eigen::Vector3d(bytes.number(1e-6, 0.1), bytes.number(1e-6, 0.1), bytes.number(1e-6, 0.1)).asDiagonal();
                    o.like_turns = 1 + bytes.byte() % 4;
                    o.yaw_known = bytes.byte() % 2 != 0;
                    o.identified = bytes.byte() % 4 == 0;
                }
                tracker.observe(time, what < 128 ? "one" : "two", frame);
                break;
            }
            case 1:
                tracker.observe(RangeObservation{time, robot, bytes.byte() % 4, bytes.number(0, 12), bytes.number(0, 0.2)});
                break;
            case 2:
                tracker.observe(RangeDifferenceObservation{time, robot, {bytes.byte() % 4, bytes.byte() % 4}, bytes.number(-5, 5), bytes.number(0, 0.2)});
                break;
            case 3:
                tracker.observe({time, robot, {bytes.number(-1, 1), bytes.number(-1, 1), bytes.number(-4, 4)}});
                break;
            case 4: {
                TagSighting tag{robot, {}, {{{bytes.number(0, 8), bytes.number(0, 6), bytes.number(-4, 4)}, 1e-2 * Eigen::Matrix3d::Identity(), true, 1}}};
                const double u = bytes.number(0, 640), v = bytes.number(0, 480), side = bytes.number(0, 40), sigma = bytes.number(1e-3, 2);
                for (int i = 0; i < 4; ++i) {
                    tag.corners.push_back({{u + (i % 3 ? side : -side), v + (i < 2 ? side : -side)}, sigma * sigma * Eigen::Matrix2d::Identity()});
                }
                tracker.observe(time, what < 250 ? "one" : "nowhere", tag);
                break;
            }
            default: {
                PlaceSighting places{robot, {}};
                places.proposals.push_back({{bytes.number(0, 8), bytes.number(0, 6), bytes.number(-4, 4)},
                                            bytes.number(1e-4, 2) * Eigen::Matrix3d::Identity(),
                                            bytes.byte() % 2 != 0,
                                            bytes.number(0, 1)});
                tracker.propose(time, "places", places);
            }
        }
        for (const Fix& fix : tracker.fixes(time)) {
            check(fix);
            if (given.empty() || fix.time >= given.back().time) given.push_back(fix);
        }
    }
    // Long silences become many knots: what takes minutes is not looked at here.
    if (given.empty() || to_seconds(given.back().time - given.front().time) > 20) return 0;
    SmootherSettings settings;
    settings.most_iterations = 3;
    const Smoothed smoothed = smooth(tracker, given, settings);
    for (const Fix& fix : smoothed.fixes) check(fix);
    return 0;
}
