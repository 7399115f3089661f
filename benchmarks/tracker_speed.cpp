// The tracker's speed on one thread: ranges, poses, many robots, late observations.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <vector>

#include "roomfix/base/random.hpp"
#include "roomfix/estimate/tracker.hpp"
#include "roomfix/evaluate/line_chart.hpp"

namespace {

using namespace roomfix;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

Site site_with(int robots, int beacons) {
    Site site;
    for (int r = 0; r < robots; ++r) {
        SiteRobot robot;
        robot.id = fmt::format("r{}", r);
        robot.shape = Box{0.4 + 0.05 * r, 0.4, 0.4};  // each its own size: none can be taken for another
        robot.drive = Drive::differential;
        robot.receivers = {Receiver{}};
        site.robots.push_back(robot);
    }
    for (int b = 0; b < beacons; ++b) {
        SiteBeacon beacon;
        beacon.id = fmt::format("b{}", b);
        beacon.position = Eigen::Vector3d(10 * (b % 2), 10 * (b / 2), 2.5);
        site.beacons.push_back(beacon);
    }
    return site;
}

/// Robots on circles, seen by one camera.
PoseObservation sighting(int robot, double t, Random& random) {
    PoseObservation o;
    o.robot = robot;
    const double angle = 0.3 * t + robot;
    o.pose = {5 + 2 * std::cos(angle) + random.normal(0.01), 5 + 2 * std::sin(angle) + random.normal(0.01), wrap_angle(angle + 1.5708 + random.normal(0.02))};
    o.covariance = Eigen::Vector3d(1e-4, 1e-4, 4e-4).asDiagonal();
    return o;
}

/// Seconds per pose update with so many robots at 30 Hz each, once the tracker remembers as much as it ever will: the least of ten
/// stretches, since other programs take their share of a machine.
double pose_cost(int robots, int rounds) {
    constexpr int before = 90;  // frames, three times the lag
    Tracker tracker(site_with(robots, 0));
    Random random(1);
    std::vector<std::vector<PoseObservation>> frames;
    for (int i = 0; i < before + rounds; ++i) {
        auto& frame = frames.emplace_back();
        for (int r = 0; r < robots; ++r) frame.push_back(sighting(r, i / 30.0, random));
    }
    const int stretch = rounds / 10;
    double start = 0, least = 1e300;
    for (int i = 0; i < before + rounds; ++i) {
        if (i >= before && (i - before) % stretch == 0) {
            if (i > before) least = std::min(least, now() - start);
            start = now();
        }
        tracker.observe(from_seconds(i / 30.0), "hall", frames[static_cast<std::size_t>(i)]);
    }
    return least / (static_cast<double>(stretch) * robots);
}

double range_cost(int updates) {
    const Site site = site_with(1, 4);
    Tracker tracker(site);
    Random random(1);
    const PoseObservation first = sighting(0, 0, random);
    tracker.observe(0, "hall", {&first, 1});
    std::vector<RangeObservation> ranges;
    for (int i = 1; i <= updates; ++i) {
        const double t = i * 0.001;
        const PoseObservation at = sighting(0, t, random);
        const auto& beacon = site.beacons[static_cast<std::size_t>(i % 4)].position;
        ranges.push_back({from_seconds(t), 0, i % 4, (Eigen::Vector3d(at.pose.x, at.pose.y, 0) - beacon).norm() + random.normal(0.02), 0.02});
    }
    const double start = now();
    for (const RangeObservation& range : ranges) tracker.observe(range);
    return (now() - start) / updates;
}

/// Seconds that one observation costs that comes a second late, with 30 frames and 20 odometry poses a second in between.
double late_cost() {
    Tracker tracker(site_with(1, 0));
    Random random(1);
    std::vector<double> costs;
    for (int i = 0; i < 3000; ++i) {
        const double t = i / 30.0;
        const PoseObservation o = sighting(0, t, random);
        tracker.observe(from_seconds(t), "hall", {&o, 1});
        tracker.observe({from_seconds(t), 0, {o.pose.x, o.pose.y, o.pose.yaw}});
        if (i % 10 != 0 || i < 60) continue;
        const double past = t - 0.99;
        const PoseObservation late = sighting(0, past, random);
        const double start = now();
        tracker.observe(from_seconds(past), "door", {&late, 1});
        costs.push_back(now() - start);
    }
    std::nth_element(costs.begin(), costs.begin() + static_cast<std::ptrdiff_t>(costs.size() / 2), costs.end());
    return costs[costs.size() / 2];
}

/// Seconds per second for look-alikes of which there may be any number, in one frame 30 times a second.
double crowd_cost(int robots) {
    Site site;
    SiteRobot cart;
    cart.id = "cart";
    cart.shape = Cylinder{0.5, 1};
    cart.many = true;
    site.robots.push_back(cart);
    Tracker tracker(site);
    Random random(1);
    const auto frame_at = [&](double t) {
        std::vector<PoseObservation> frame;
        for (int r = 0; r < robots; ++r) {
            PoseObservation o;
            o.pose = {2.0 * (r % 40) + 0.5 * std::sin(t + r) + random.normal(0.02), 2.0 * (r / 40) + 0.5 * std::cos(t + r) + random.normal(0.02), 0};
            o.yaw_known = false;
            o.covariance = Eigen::Vector3d(4e-4, 4e-4, 1).asDiagonal();
            frame.push_back(o);
        }
        return frame;
    };
    double spent = 0;
    for (int i = 0; i < 90; ++i) {
        const auto frame = frame_at(i / 30.0);
        const double start = now();
        tracker.observe(from_seconds(i / 30.0), "hall", frame);
        if (i >= 30) spent += now() - start;
    }
    return spent / 2;
}

}  // namespace

/// `tracker_speed FILE.svg` draws the cost per robot, too.
int main(int argc, char** argv) {
    fmt::print("scalar-range updates per second: {:.0f} (goal 1000000)\n", 1 / range_cost(300000));
    fmt::print("pose updates per second: {:.0f} (goal 300000)\n", 1 / pose_cost(1, 100000));
    LineChart chart{"Cost per robot", "robots", "microseconds per robot and pose", {{"measured", {}, false}}, false};
    for (const int robots : {1, 2, 5, 10, 20, 50, 100, 200, 400, 600, 800, 1000}) {
        const double cost = 1e6 * pose_cost(robots, std::max(120, 20000 / robots));
        fmt::print("{:5} robots: {:.2f} us per robot and pose\n", robots, cost);
        chart.curves[0].points.emplace_back(robots, cost);
    }
    if (argc > 1) std::ofstream(argv[1]) << svg_of(chart);
    fmt::print("1000 robots at 30 Hz: {:.3f} s per second (goal < 1)\n", 30000 * pose_cost(1000, 90));
    fmt::print("1000 look-alikes at 30 Hz: {:.3f} s per second (goal < 1)\n", crowd_cost(1000));
    fmt::print("an observation that comes 1 s late: {:.0f} us (goal 200)\n", 1e6 * late_cost());
    return 0;
}
