// Recorded ranges: how much robust trilateration wins over plain least squares. The figures stand in docs/kim2011.md.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "data_folder.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/connect/odometry_source.hpp"
#include "roomfix/estimate/tracker.hpp"
#include "roomfix/evaluate/consistency.hpp"
#include "roomfix/evaluate/error_report.hpp"
#include "roomfix/ranging/range_reader.hpp"
#include "roomfix/ranging/trilateration.hpp"
#include "roomfix/site/load_site.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

std::vector<std::vector<double>> numbers_of(const fs::path& file) {
    std::vector<std::vector<double>> rows;
    for (const auto& fields : csv_rows(file)) {
        rows.emplace_back();
        for (const std::string& field : fields) rows.back().push_back(parse_number(field).value_or(0));
    }
    return rows;
}

Eigen::Vector2d place_at(const std::vector<std::vector<double>>& truth, double time) {
    auto next = std::lower_bound(truth.begin() + 1, truth.end(), time, [](const auto& row, double t) { return row[0] < t; });
    if (next == truth.end()) --next;
    const auto& a = *(next - 1);
    const auto& b = *next;
    const double part = std::clamp((time - a[0]) / std::max(b[0] - a[0], 1e-9), 0.0, 1.0);
    return {a[2] + part * (b[2] - a[2]), a[3] + part * (b[3] - a[3])};
}

/// Radio ranges outdoors are late by metres, all of them. That they share a delay is all the robust method is told.
TEST(RangeData, RobustTrilaterationBeatsLeastSquaresOnPlaza1) {
    const fs::path folder = data_folder("plaza1");
    if (!fs::exists(folder / "ranges.csv")) GTEST_SKIP() << "no data in " << folder << ": set ROOMFIX_DATA";
    const auto site = load_site(folder / "site.yaml");
    ASSERT_TRUE(site) << site.error().message;
    RangeReader reader(*site, 0);
    RangeBatch batch;
    reader.feed(text_of(folder / "ranges.csv"), std::nullopt, batch);
    reader.finish(std::nullopt, batch);
    EXPECT_GT(batch.ranges.size(), 3400U);
    const auto truth = numbers_of(folder / "truth.csv");

    std::vector<double> plain_errors, robust_errors;
    for (std::size_t i = 0; i + 1 < batch.ranges.size();) {
        // One place per 2.5 s: the newest range of each beacon.
        std::map<int, BeaconRange> newest;
        const double begin = to_seconds(batch.ranges[i].time);
        double time = begin;
        for (; i < batch.ranges.size() && to_seconds(batch.ranges[i].time) < begin + 2.5; ++i) {
            const RangeObservation& r = batch.ranges[i];
            newest[r.beacon] = {site->beacons[static_cast<std::size_t>(r.beacon)].position, r.range, 0.5};
            time = to_seconds(r.time);
        }
        if (newest.size() < 3) continue;
        std::vector<BeaconRange> ranges;
        for (const auto& [beacon, range] : newest) ranges.push_back(range);
        const Eigen::Vector2d where = place_at(truth, 0.5 * (begin + time));
        const auto plain = trilaterate(ranges, {}, 0, {.robust = false, .largest_sigma = 50});
        const auto robust = trilaterate(ranges, {}, 0, {.late = {.share = 0.3, .mean = 2}, .largest_sigma = 50, .shared_delay = 3});
        if (!plain || !robust) continue;
        plain_errors.push_back((plain->places[0].position - where).norm());
        robust_errors.push_back((robust->places[0].position - where).norm());
    }
    const Summary plain = summarise(plain_errors);
    const Summary robust = summarise(robust_errors);
    fmt::print("plaza1, {} places: least squares {:.2f} m rms, {:.2f} m median; robust {:.2f} m rms, {:.2f} m median\n", plain.count, plain.rms, plain.median,
               robust.rms, robust.median);
    EXPECT_GT(plain.count, 300U);
    EXPECT_LT(robust.rms, 0.75 * plain.rms);
}

/// Wheels alone, with the true pose to start from: what the ranges have to beat.
double odometry_alone(const std::vector<OdometryObservation>& poses, const std::vector<StampedPose>& truth) {
    std::vector<double> errors;
    const Pose2 start = *pose_at(truth, poses.front().time);
    const Eigen::Rotation2Dd turn(start.yaw - poses.front().pose.yaw);
    for (const OdometryObservation& o : poses) {
        const auto where = pose_at(truth, o.time);
        if (!where) continue;
        const Eigen::Vector2d way = turn * Eigen::Vector2d(o.pose.x - poses.front().pose.x, o.pose.y - poses.front().pose.y);
        errors.push_back((Eigen::Vector2d(start.x, start.y) + way - Eigen::Vector2d(where->x, where->y)).norm());
    }
    return summarise(errors).rms;
}

/// Wheels and ranges together: how far off all ranges are, how much too long, and where the robot stands and looks, all unknown at the start.
TEST(RangeData, TheTrackerLearnsTheRangesErrorsOnPlaza1) {
    const fs::path folder = data_folder("plaza1");
    if (!fs::exists(folder / "ranges.csv")) GTEST_SKIP() << "no data in " << folder << ": set ROOMFIX_DATA";
    Site site = *load_site(folder / "site.yaml");
    SiteRobot& mower = site.robots[0];
    mower.drive = Drive::differential;
    mower.odometry = WheelOdometry{};
    mower.odometry->drift_sigma = 0.002;
    Receiver receiver;
    receiver.sigma = 0.7;
    receiver.bias_sigma = 2;
    receiver.scale_sigma = 0.05;
    mower.receivers = {receiver};
    TrackerSettings settings;
    site.lost = 10;  // outdoors, metres count
    Tracker tracker(site, settings);

    const auto driven = load_odometry((folder / "odometry.csv").string(), site, 0);
    const auto truth = load_truth((folder / "truth.csv").string());
    ASSERT_TRUE(driven && truth);
    RangeReader reader(site, 0);
    RangeBatch batch;
    reader.feed(text_of(folder / "ranges.csv"), std::nullopt, batch);
    reader.finish(std::nullopt, batch);
    // The recording's clock jumps back twice.
    std::stable_sort(batch.ranges.begin(), batch.ranges.end(), [](const auto& a, const auto& b) { return a.time < b.time; });

    RecordedFixes recorded;
    std::map<int, BeaconRange> newest;
    std::size_t next = 0;
    bool started = false;
    for (const RangeObservation& r : batch.ranges) {
        while (next < driven->poses.size() && driven->poses[next].time <= r.time) tracker.observe(driven->poses[next++]);
        newest[r.beacon] = {site.beacons[static_cast<std::size_t>(r.beacon)].position, r.range, 0.5};
        if (!started && newest.size() == 4) {
            std::vector<BeaconRange> ranges;
            for (const auto& [beacon, range] : newest) ranges.push_back(range);
            const auto found = trilaterate(ranges, {}, 0, {.late = {.share = 0.3, .mean = 2}, .largest_sigma = 50, .shared_delay = 3});
            ASSERT_TRUE(found);
            PlaceSighting places;
            for (const TrilaterationPlace& place : found->places) {
                PlaceProposal proposal{{place.position.x(), place.position.y(), 0}, 4 * Eigen::Matrix3d::Identity(), false, place.weight};
                proposal.covariance.topLeftCorner<2, 2>() += place.covariance;
                places.proposals.push_back(proposal);
            }
            tracker.propose(r.time, "trilateration", places);
            started = true;
        }
        tracker.observe(r);
        for (const Fix& fix : tracker.fixes(r.time)) recorded.fixes.push_back(fix);
    }
    const ErrorReport report = judge(recorded, *truth);
    const double wheels = odometry_alone(driven->poses, truth->at("mower"));
    fmt::print(
        "plaza1, {} fixes: tracker {:.2f} m rms, {:.2f} m median, {:.2f} m at most; odometry alone, told its start, {:.2f} m rms; NEES per dimension {:.2f}\n",
        report.all.position.count, report.all.position.rms, report.all.position.median, report.all.position.max, wheels, report.all.nees.mean);
    if (const char* file = std::getenv("ROOMFIX_REPORT")) std::ofstream(file) << html_of(report, "plaza1: ranges and odometry");
    EXPECT_LT(report.all.position.rms, 0.5 * wheels);
    EXPECT_LT(report.all.position.rms, 1.0);
    EXPECT_GT(report.availability, 0.4);
}

}  // namespace
}  // namespace roomfix
