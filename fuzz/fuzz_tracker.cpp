// Any observations at any times: whatever the tracker gives out is finite and has a positive definite covariance.
#include <Eigen/Cholesky>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "roomfix/estimate/tracker.hpp"

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
        site.robots[i].receiver = Receiver{};
        site.robots[i].receiver->bias_sigma = i == 2 ? 0.5 : 0;
        site.robots[i].receiver->scale_sigma = i == 2 ? 0.05 : 0;
    }
    site.robots[0].drive = Drive::differential;
    site.robots[2].drive = Drive::holonomic;
    site.beacons.resize(3);
    for (std::size_t i = 0; i < 3; ++i) site.beacons[i].position = Eigen::Vector3d(4.0 * static_cast<double>(i), 3.0 * static_cast<double>(i % 2), 2.5);
    return site;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace roomfix;
    static const Site site = make_site();
    if (size > 4000) return 0;
    Tracker tracker(site);
    Bytes bytes(data, size);
    Nanoseconds time = 1'000'000'000'000;
    while (!bytes.empty()) {
        const std::uint8_t what = bytes.byte();
        const double step = bytes.number(-0.5, 1.0);
        if (std::isfinite(step) && std::abs(step) < 1e6) time += from_seconds(step);
        const int robot = bytes.byte() % 6 - 1;
        switch (what % 5) {
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
                tracker.see(time, what < 128 ? "one" : "two", frame);
                break;
            }
            case 1:
                tracker.hear(RangeObservation{time, robot, bytes.byte() % 4, bytes.number(0, 12), bytes.number(0, 0.2)});
                break;
            case 2:
                tracker.hear(RangeDifferenceObservation{time, robot, {bytes.byte() % 4, bytes.byte() % 4}, bytes.number(-5, 5), bytes.number(0, 0.2)});
                break;
            case 3:
                tracker.drive({time, robot, {bytes.number(-1, 1), bytes.number(-1, 1), bytes.number(-4, 4)}});
                break;
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
            if (fix.status == FixStatus::none) continue;
            const bool finite = std::isfinite(fix.pose.x) && std::isfinite(fix.pose.y) && std::isfinite(fix.pose.yaw) && fix.covariance.allFinite();
            if (!finite || Eigen::LLT<Eigen::Matrix3d>(fix.covariance).info() != Eigen::Success) __builtin_trap();
        }
    }
    return 0;
}
