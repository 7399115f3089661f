// People and other things that are no robots, and robots that are put on them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "evaluate/tracks.hpp"
#include "roomfix/evaluate/error_report.hpp"

namespace roomfix {
namespace {

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Two robots, and a person 3 m beside them.
Truth with_a_person() {
    Truth truth = side_by_side();
    drive(truth, "unknown-1", 6);
    return truth;
}

RecordedFixes both_robots() {
    RecordedFixes recorded;
    follow(recorded.fixes, "r1", 0);
    follow(recorded.fixes, "r2", 3);
    return recorded;
}

std::string line_of(double t, double y, const std::string& rest) {
    return fmt::format(
        "{{\"time\": {}, \"robot\": null, {}, \"status\": \"ok\", \"x\": {}, \"y\": {}, \"covariance\": [0.01,0,0,0,0.01,0,0,0,9], \"sources\": [\"hall\"]}}\n",
        t, rest, t, y);
}

TEST(UnknownThings, AreReadApartFromRobots) {
    const std::string thing = "\"kind\": \"unknown\", \"id\": \"unknown-3\"";
    const RecordedFixes recorded =
        parse_fixes(line_of(2, 6, thing) + line_of(1, 6, thing + ", \"yaw\": null") + line_of(1, 6, "\"kind\": \"unknown\"") +
                    line_of(1, 6, "\"kind\": \"unknown\", \"id\": 3") + line_of(1, 6, "\"kind\": \"person\", \"id\": \"p\"") + line_of(1, 6, "\"yaw\": null") +
                    line_of(1, 6, "\"id\": \"unknown-4\"") +
                    "{\"time\": 3, \"robot\": null, \"kind\": \"unknown\", \"id\": \"unknown-3\", \"status\": \"none\", \"reason\": \"gone\"}\n");
    ASSERT_EQ(recorded.unknown_things.size(), 3U);
    EXPECT_EQ(recorded.unknown_things[0].time, from_seconds(1)) << "in the order of their times";
    EXPECT_EQ(recorded.unknown_things[1].robot, "unknown-3");
    EXPECT_FALSE(recorded.unknown_things[1].yaw_known);
    EXPECT_EQ(recorded.unknown_things[2].status, FixStatus::none);
    ASSERT_EQ(recorded.fixes.size(), 1U) << "a camera that belongs to no robot";
    ASSERT_EQ(recorded.problems.size(), 4U);
    EXPECT_TRUE(says(recorded.problems[0], "line 3: an unknown thing needs an 'id'")) << recorded.problems[0];
    EXPECT_TRUE(says(recorded.problems[1], "line 4: an unknown thing needs an 'id'")) << recorded.problems[1];
    EXPECT_TRUE(says(recorded.problems[2], "line 5: kind \"person\" is not \"unknown\"")) << recorded.problems[2];
    EXPECT_TRUE(says(recorded.problems[3], "line 7: ")) << "all others have to say that they know no yaw: " << recorded.problems[3];
}

TEST(UnknownThings, InTheTruthAreNumberedWhereThereAreSeveral) {
    ASSERT_TRUE(parse_truth("time,robot,x,y\n1,unknown,0,0\n2,unknown,1,0\n1,unknown-2,5,0\n1,r1,0,0\n1,r1,0,0\n"));
    const auto twice = parse_truth("time,robot,x,y\n1.5,unknown,0,0\n1.5,unknown,4,0\n");
    ASSERT_FALSE(twice);
    EXPECT_TRUE(says(twice.error().message, "'unknown' is at two places at 1.5 s: number such things, unknown-1")) << twice.error().message;
    EXPECT_TRUE(names_unknown_thing("unknown"));
    EXPECT_TRUE(names_unknown_thing("unknown-12"));
    EXPECT_FALSE(names_unknown_thing("unknowns"));
    EXPECT_FALSE(names_unknown_thing("r1"));
}

TEST(UnknownThings, DoNotChangeWhatIsSaidOfRobots) {
    RecordedFixes recorded = both_robots();
    const ErrorReport without = judge(recorded, side_by_side());
    follow(recorded.unknown_things, "unknown-3", 6);
    Truth truth = with_a_person();
    drive(truth, "unknown-2", 9, 200);  // stays longer than the robots' truth goes
    const ErrorReport with = judge(recorded, truth);
    EXPECT_EQ(with.gospa.moments, 100U);
    EXPECT_EQ(with.availability, 1);
    EXPECT_EQ(with.gospa.mean, without.gospa.mean);
    EXPECT_EQ(with.identities.f1(), 1);
    EXPECT_EQ(with.all.position.count, without.all.position.count);
    EXPECT_TRUE(with.unknown_robots.empty());
}

TEST(UnknownThings, AreFoundPartOfTheTimeAndAPartIsFalse) {
    RecordedFixes recorded = both_robots();
    follow(recorded.unknown_things, "unknown-3", 6.1, 0, 49);  // the last one holds for a quarter of a second, two more moments
    follow(recorded.unknown_things, "unknown-4", 20, 20, 30);
    follow(recorded.unknown_things, "unknown-4", 20, 60, 70);
    const ErrorReport report = judge(recorded, with_a_person());
    const UnknownThings& things = report.unknown_things;
    EXPECT_EQ(things.listed, 100U);
    EXPECT_EQ(things.found, 51U);
    EXPECT_NEAR(things.error.mean, 0.1, 1e-9);
    EXPECT_EQ(things.false_ones, 2U) << "twice for a while";
    EXPECT_NEAR(things.false_per_minute(), 2 / (9.9 / 60), 1e-9);
    EXPECT_EQ(things.robots_on_one, 0U);
    for (const std::string& text : {text_of(report), html_of(report, "t")}) {
        EXPECT_TRUE(says(text, "unknown things: found 51.0 % of the time, mean error 0.100 m, 12.1 false ones a minute")) << text;
        EXPECT_TRUE(says(text, "robots put on what is no robot: 0 of 200 ok fixes (0.00 %)")) << text;
    }
}

TEST(UnknownThings, HaveRobotsPutOnThem) {
    RecordedFixes recorded;
    follow(recorded.fixes, "r1", 0, 0, 80);
    follow(recorded.fixes, "r1", 6.2, 80, 90);  // on the person
    follow(recorded.fixes, "r1", 6.4, 90, 95);  // beside the person, on nothing
    follow(recorded.fixes, "r9", 5.9, 50, 55);  // a robot that is not there at all
    for (int i = 95; i < 100; ++i) {            // a prediction claims less
        recorded.fixes.push_back(ok_fix(0.1 * i, "r1", 0.1 * i, 6));
        recorded.fixes.back().status = FixStatus::coasting;
    }
    const ErrorReport report = judge(recorded, with_a_person());
    EXPECT_EQ(report.unknown_things.robots_on_one, 15U);
    EXPECT_EQ(report.unknown_things.robot_fixes, 100U);
    EXPECT_TRUE(says(text_of(report), "robots put on what is no robot: 15 of 100 ok fixes (15.00 %)")) << text_of(report);
    EXPECT_TRUE(says(text_of(report), "Robot r9: the truth does not know it. GOSPA, IDF1 and HOTA take it for false.")) << text_of(report);

    Truth near = side_by_side();
    drive(near, "unknown", 0.2);  // who walks beside the robot
    EXPECT_EQ(judge(both_robots(), near).unknown_things.robots_on_one, 0U);
}

TEST(UnknownThings, WithoutATruthAreNotJudged) {
    RecordedFixes recorded = both_robots();
    follow(recorded.unknown_things, "unknown-3", 6);
    const ErrorReport report = judge(recorded, side_by_side());
    const std::string sentence = "unknown things: 100 fixes; the truth has no robot 'unknown' to compare them with";
    EXPECT_TRUE(says(text_of(report), sentence)) << text_of(report);
    EXPECT_TRUE(says(html_of(report, "t"), "unknown things: 100 fixes")) << html_of(report, "t");
    EXPECT_FALSE(says(text_of(report), "robots put on"));
    EXPECT_FALSE(says(text_of(judge(both_robots(), side_by_side())), "unknown things"));
}

TEST(ConfidentlyWrong, AreFixesOfStatusOkThatAreFarOff) {
    RecordedFixes recorded;
    for (int i = 0; i < 100; ++i) {
        const bool off = i < 9;
        recorded.fixes.push_back(ok_fix(0.1 * i, "r1", 0.1 * i, off ? 0.6 : 0.4, off ? 0.01 * (i + 1) : 0.3));
    }
    recorded.fixes.back().pose.y = 5;
    recorded.fixes.back().status = FixStatus::coasting;
    const ErrorReport report = judge(recorded, side_by_side());
    EXPECT_EQ(report.confidently_wrong.fixes, 99U);
    EXPECT_EQ(report.confidently_wrong.wrong, 9U);
    EXPECT_NEAR(report.confidently_wrong.stated_sigma, 0.05 * std::sqrt(2.0), 1e-9);
    EXPECT_TRUE(says(text_of(report), "confidently wrong: 9 of 99 ok fixes (9.09 %) are farther than 0.5 m from the truth; they state 0.071 m (median)"))
        << text_of(report);
    EXPECT_TRUE(says(text_of(judge(both_robots(), side_by_side())), "confidently wrong: none of 200 ok fixes"));
}

TEST(SeveralTargetsReport, SaysTheSameAsTextAsJsonAndAsAPage) {
    RecordedFixes recorded;
    recorded.fixes = swapped_halves();
    follow(recorded.unknown_things, "unknown-3", 6.1);
    const ErrorReport report = judge(recorded, with_a_person(), {.cutoff = 2});
    const std::string text = text_of(report), page = html_of(report, "t");
    EXPECT_TRUE(says(text, "all robots together, over 100 moments of the truth, cut-off 2.00 m\nGOSPA  0.000 m on average")) << text;
    EXPECT_TRUE(says(text, "IDF1   0.500 (precision 0.500, recall 0.500)\nHOTA   0.577 (DetA 1.000, AssA 0.333)\n")) << text;
    EXPECT_TRUE(says(page, "<td>HOTA</td><td class=\"text\">0.577 (DetA 1.000, AssA 0.333)</td>")) << page;
    const auto json = nlohmann::json::parse(json_of(report));
    EXPECT_EQ(json["gospa"]["cutoff"], 2);
    EXPECT_EQ(json["gospa"]["moments"], 100);
    EXPECT_EQ(json["gospa"]["missed_at_once"], 0);
    EXPECT_EQ(json["idf1"]["idtp"], 100);
    EXPECT_NEAR(json["hota"]["assa"].get<double>(), 1.0 / 3, 1e-12);
    EXPECT_EQ(json["confidently_wrong"]["wrong"], 100);
    EXPECT_EQ(json["unknown_things"]["found"], 1);
    EXPECT_EQ(json["unknown_things"]["robots_on_one"], 0);
}

}  // namespace
}  // namespace roomfix
