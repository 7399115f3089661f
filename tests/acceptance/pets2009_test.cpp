// Real footage: PETS 2009 S2.L1 view 1.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "data_folder.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/connect/frame_source.hpp"
#include "roomfix/estimate/tracker.hpp"
#include "roomfix/evaluate/consistency.hpp"
#include "roomfix/evaluate/detections.hpp"
#include "roomfix/overhead/overhead_observer.hpp"
#include "roomfix/pipeline/background_source.hpp"
#include "roomfix/site/load_site.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

const fs::path pets_folder = data_folder("pets2009");

std::map<int, std::vector<Eigen::Vector2d>> read_truth(const fs::path& file) {
    std::map<int, std::vector<Eigen::Vector2d>> truth;
    for (const auto& row : csv_rows(file)) truth[static_cast<int>(*parse_integer(row.at(0)))].push_back({*parse_number(row.at(2)), *parse_number(row.at(3))});
    return truth;
}

/// Of people in single frames, and as they are tracked.
struct PeopleCount {
    DetectionCount frames, tracked;
};

PeopleCount count_people(bool learned_first) {
    const Site site = *load_site(pets_folder / "site.yaml");
    const auto truth = read_truth(pets_folder / "truth.csv");
    OverheadObserver observer(*fixed_view(site.cameras[0]), site.robots);
    const std::string video = (pets_folder / "vtest.avi").string();
    if (learned_first) observer.set_background(std::move(learn_background(site.cameras[0], {video})->grey));
    Tracker tracker(site);
    auto source = open_source(video);
    SourceFrame frame;
    OverheadResult result;
    PeopleCount count;
    for (int number = 1; number <= truth.rbegin()->first && *(*source)->next(frame); ++number) {
        observer.observe(frame.image, result);
        tracker.observe(frame.time, "view1", poses_of(result.observations));
        const auto people = truth.find(number);
        if (people == truth.end()) continue;
        std::vector<Eigen::Vector2d> found, tracked;
        for (const auto& o : result.observations) found.emplace_back(o.pose.x, o.pose.y);
        for (const Fix& fix : tracker.fixes(frame.time)) {
            if (fix.status != FixStatus::none) tracked.emplace_back(fix.pose.x, fix.pose.y);
        }
        count_frame(people->second, found, 1.0, count.frames);
        count_frame(people->second, tracked, 1.0, count.tracked);
    }
    return count;
}

void print(const char* what, const DetectionCount& c) {
    const Summary errors = summarise(c.errors);
    fmt::print("PETS 2009, {}: {} listed, {} found ({:.0f} %), {} missed, {} false ({:.0f} % of what was reported); error median {:.2f} m, p95 {:.2f} m\n",
               what, c.listed, c.found, 100.0 * c.found / c.listed, c.missed, c.false_ones, 100.0 * c.false_ones / (c.found + c.false_ones), errors.median,
               errors.p95);
}

TEST(Pets2009, PeopleAreFoundInRealFootage) {
    if (!fs::exists(pets_folder / "vtest.avi")) GTEST_SKIP() << pets_folder << " is absent: set ROOMFIX_DATA to a pets_folder that holds pets2009/";
    const PeopleCount learned = count_people(true), live = count_people(false);
    print("background learned first, single frames", learned.frames);
    print("background learned first, tracked", learned.tracked);
    print("live from the first frame, tracked", live.tracked);
    print("live from the first frame, single frames", live.frames);
    EXPECT_EQ(learned.tracked.listed, 72);
    EXPECT_GE(learned.frames.found, 0.75 * learned.frames.listed);
    for (const DetectionCount& count : {learned.tracked, live.tracked}) {
        EXPECT_GE(count.found, 0.85 * count.listed);
        EXPECT_LE(count.false_ones, 0.10 * (count.found + count.false_ones));
        EXPECT_LE(summarise(count.errors).median, 0.40);
    }
}

}  // namespace
}  // namespace roomfix
