// Fixes in an SQLite file, and questions for them as the page asks them.
#include "roomfix/connect/history_answer.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "roomfix/connect/web_server.hpp"

namespace roomfix {
namespace {

class History : public ::testing::Test {
protected:
    void SetUp() override {
        std::filesystem::create_directories(folder);
        store = open("lab", 1);
    }
    void TearDown() override {
        store.reset();
        std::filesystem::remove_all(folder);
    }
    std::unique_ptr<FixStore> open(const std::string& site, std::int64_t run) {
        auto opened = FixStore::open((folder / "history.db").string(), site, run);
        return opened ? std::move(*opened) : nullptr;
    }
    WebAnswer ask(const WebParameters& parameters) { return answer_history(*store, parameters); }
    long count(const WebParameters& parameters) {
        const WebAnswer answer = ask(parameters);
        EXPECT_EQ(answer.status, 200) << answer.body;
        return std::count(answer.body.begin(), answer.body.end(), '\n');
    }

    std::filesystem::path folder = std::filesystem::temp_directory_path() / fmt::format("roomfix_history_{}", getpid());
    std::unique_ptr<FixStore> store;
};

Fix fix_at(const std::string& robot, Nanoseconds time, double x, double y) {
    Fix fix;
    fix.time = time;
    fix.robot = robot;
    fix.status = FixStatus::ok;
    fix.pose = {x, y, 1.0 / 3};
    fix.covariance << 0.01, 0.001, 0.002, 0.001, 0.02, 0.003, 0.002, 0.003, 1.0 / 7;
    fix.sources = {"hall", "ranges"};
    return fix;
}

/// A robot r1 that goes along x by a metre each second, and r2 that stands.
std::vector<NumberedFix> two_robots() {
    std::vector<NumberedFix> fixes;
    for (int i = 0; i < 10; ++i) {
        fixes.push_back({2 * i, fix_at("r1", from_seconds(1.7e9) + 1'000'000'007LL * i, i, 2)});
        fixes.push_back({2 * i + 1, fix_at("r2", from_seconds(1.7e9) + 1'000'000'007LL * i, 5, 5)});
    }
    return fixes;
}

TEST_F(History, WhatIsStoredComesBackToTheSameNumbers) {
    Fix none;
    none.time = 3;
    none.robot = "r1's \"twin\"";
    none.reason = "nobody sees it; DROP TABLE roomfix_fixes; --";
    Fix thing = fix_at("unknown-1", 2, 1e-9, -1234567.125);
    thing.unknown = true;
    thing.yaw_known = false;
    const std::vector<NumberedFix> fixes = {{0, fix_at("r1", 1, 0.1 + 0.2, -1.0 / 3)}, {1, thing}, {2, none}};
    ASSERT_TRUE(store->add(fixes));
    const auto found = store->find({.newest_first = false});
    ASSERT_TRUE(found) << found.error().message;
    ASSERT_EQ(found->size(), 3U);
    EXPECT_EQ((*found)[0].time, 1);
    EXPECT_DOUBLE_EQ((*found)[0].pose.x, 0.1 + 0.2);
    EXPECT_DOUBLE_EQ((*found)[0].pose.yaw, 1.0 / 3);
    EXPECT_TRUE((*found)[0].covariance.isApprox(fixes[0].fix.covariance, 1e-15));
    EXPECT_EQ((*found)[0].sources, fixes[0].fix.sources);
    EXPECT_TRUE((*found)[1].unknown);
    EXPECT_FALSE((*found)[1].yaw_known);
    EXPECT_EQ((*found)[1].status, FixStatus::ok);
    EXPECT_EQ((*found)[2].status, FixStatus::none);
    EXPECT_EQ((*found)[2].robot, none.robot);
    EXPECT_EQ((*found)[2].reason, none.reason);
}

TEST_F(History, WhatIsGivenTwiceIsStoredOnceAndAnotherRunIsAnother) {
    const auto fixes = two_robots();
    ASSERT_TRUE(store->add(fixes));
    ASSERT_TRUE(store->add(fixes));
    EXPECT_EQ(store->find({})->size(), 20U);
    ASSERT_TRUE(open("lab", 2)->add(fixes));
    EXPECT_EQ(store->find({})->size(), 40U);
    ASSERT_TRUE(open("another", 1)->add(fixes));
    EXPECT_EQ(store->find({})->size(), 40U) << "a site sees its own fixes only";
}

TEST_F(History, IsFoundByRobotTimeAndArea) {
    ASSERT_TRUE(store->add(two_robots()));
    EXPECT_EQ(count({}), 20);
    EXPECT_EQ(count({{"robot", "r1"}}), 10);
    EXPECT_EQ(count({{"robot", "r3"}}), 0);
    EXPECT_EQ(count({{"from", "1700000003.000000021"}, {"robot", "r1"}}), 7);
    EXPECT_EQ(count({{"from", "1700000003.000000022"}, {"robot", "r1"}}), 6) << "to the nanosecond";
    EXPECT_EQ(count({{"to", "1700000003"}, {"robot", "r1"}}), 3);
    EXPECT_EQ(count({{"area", "5.5,3,2,0"}}), 4) << "x from 2 to 5.5, whichever corners they are";
    EXPECT_EQ(count({{"area", "4,4,6,6"}}), 10);
    const WebAnswer newest = ask({{"robot", "r1"}, {"limit", "2"}});
    EXPECT_EQ(nlohmann::json::parse(newest.body.substr(0, newest.body.find('\n')))["x"], 9);
    const WebAnswer oldest = ask({{"robot", "r1"}, {"limit", "2"}, {"order", "oldest"}});
    EXPECT_EQ(nlohmann::json::parse(oldest.body.substr(0, oldest.body.find('\n')))["x"], 0);
    ASSERT_TRUE(store->remove_before(from_seconds(1.7e9 + 5.5)));
    EXPECT_EQ(count({}), 8);
}

TEST_F(History, SaysWhatIsWrongWithAQuestion) {
    const auto says = [&](const WebParameters& parameters, const std::string& words) {
        const WebAnswer answer = ask(parameters);
        EXPECT_EQ(answer.status, 400);
        EXPECT_NE(answer.body.find(words), std::string::npos) << answer.body;
    };
    says({{"from", "yesterday"}}, "'yesterday' is no time: from is given in seconds");
    says({{"to", "nan"}}, "no time");
    says({{"from", "2"}, {"to", "1"}}, "from lies after to");
    says({{"area", "1,2,3"}}, "area=x1,y1,x2,y2");
    says({{"area", "1,2,3,inf"}}, "area=x1,y1,x2,y2");
    says({{"limit", "0"}}, "from 1 to 100000");
    says({{"limit", "100001"}}, "from 1 to 100000");
    says({{"limit", "99999999999999999999"}}, "from 1 to 100000");
    says({{"order", "random"}}, "order is oldest or newest");
    says({{"format", "xml"}}, "format is jsonl or csv");
    says({{"robots", "r1"}}, "'robots' is not known");
    says({{"robot", ""}}, "is no robot's name");
    says({{"robot", "' OR 1=1 --"}}, "is no robot's name");
    says({{"robot", "\xff\xfe"}}, "'\?\?' is no robot's name");
    says({{"robot", "r1"}, {"robot", "r2"}}, "given twice");
    says({{"robot", std::string(201, 'x')}}, "too long");
    says({{"from", "<script>\n\x01"}}, "'<script>\?\?'");
}

TEST_F(History, CsvHasAHeaderAndAFieldForEachNumber) {
    Fix none;
    none.time = 1'500'000'000;
    none.robot = "a,\"b\"";
    const std::vector<NumberedFix> fixes = {{0, fix_at("r1", 1, 0.5, 2)}, {1, none}};
    ASSERT_TRUE(store->add(fixes));
    const WebAnswer answer = ask({{"format", "csv"}, {"order", "oldest"}});
    EXPECT_EQ(answer.type, "text/csv");
    EXPECT_EQ(answer.body,
              "time,robot,kind,status,x,y,yaw,xx,xy,xyaw,yy,yyaw,yawyaw,sources\n"
              "0.000000001,r1,robot,ok,0.5,2,0.3333333333333333,0.01,0.001,0.002,0.02,0.003,0.14285714285714285,hall ranges\n"
              "1.5,\"a,\"\"b\"\"\",robot,none,,,,,,,,,,\n");
}

TEST_F(History, ADatabaseThatIsNoneIsSaidAndAnotherFileInItsPlaceIsUsed) {
    std::ofstream(folder / "broken.db") << std::string(5000, 'x');
    auto broken = FixStore::open((folder / "broken.db").string(), "lab");
    const WebAnswer answer = answer_history(**broken, {});
    EXPECT_EQ(answer.status, 503);
    EXPECT_NE(answer.body.find("move it away"), std::string::npos) << answer.body;
    std::filesystem::remove(folder / "broken.db");
    EXPECT_EQ(answer_history(**broken, {}).status, 200);
    auto nowhere = FixStore::open((folder / "no such folder" / "history.db").string(), "lab");
    EXPECT_NE(answer_history(**nowhere, {}).body.find("check that the folder exists"), std::string::npos);
    const auto strange = FixStore::open("mysql://host/database", "lab");
    ASSERT_FALSE(strange);
    EXPECT_NE(strange.error().message.find("postgresql://"), std::string::npos);
}

TEST_F(History, AFileThatIsDeletedWhileItIsOpenIsMadeAnew) {
    ASSERT_TRUE(store->add(two_robots()));
    for (const char* name : {"history.db", "history.db-wal", "history.db-shm"}) std::filesystem::remove(folder / name);
    ASSERT_TRUE(store->add(two_robots()));
    EXPECT_EQ(store->find({})->size(), 20U);
    EXPECT_TRUE(std::filesystem::exists(folder / "history.db"));
}

TEST_F(History, TellsWhoEnteredAndLeftZones) {
    const std::vector<NumberedZoneEvent> events = {
        {0, {from_seconds(1), "dock", "r1", true}}, {1, {from_seconds(2), "gate", "r'2", true}}, {2, {from_seconds(3), "dock", "r1", false}}};
    ASSERT_TRUE(store->add({}, events));
    ASSERT_TRUE(store->add({}, events)) << "what is given twice is stored once";
    const auto lines = [&](const WebParameters& parameters) { return answer_zone_history(*store, parameters); };
    EXPECT_EQ(lines({{"zone", "dock"}}).body,
              "{\"time\": 3.0, \"robot\": \"r1\", \"zone\": \"dock\", \"event\": \"leave\"}\n{\"time\": 1.0, \"robot\": \"r1\", \"zone\": \"dock\", \"event\": "
              "\"enter\"}\n");
    EXPECT_NE(lines({{"from", "1.5"}, {"to", "2.5"}}).body.find("\"r'2\""), std::string::npos);
    const std::string body = lines({{"limit", "1"}, {"order", "oldest"}}).body;
    EXPECT_EQ(std::count(body.begin(), body.end(), '\n'), 1);
    EXPECT_NE(body.find("\"time\": 1.0,"), std::string::npos);
    EXPECT_EQ(lines({{"area", "0,0,1,1"}}).status, 400);
    EXPECT_EQ(lines({{"zone", "a b"}}).status, 400);
    EXPECT_EQ(ask({{"zone", "dock"}}).status, 400) << "fixes have no zone";
    ASSERT_TRUE(store->remove_before(from_seconds(2.5)));
    EXPECT_EQ(lines({}).body.find("enter"), std::string::npos);
}

TEST_F(History, IsAnsweredOverHttp) {
    ASSERT_TRUE(store->add(two_robots()));
    WebServer server;
    ASSERT_TRUE(server.start({"127.0.0.1", 0}));
    httplib::Client client("127.0.0.1", server.port());
    EXPECT_EQ(client.Get("/api/history")->status, 404);
    server.add_route("GET /api/history", [this](const WebQuestion& question) { return ask(question.parameters); });
    const auto answer = client.Get("/api/history?robot=r1&area=-1,1,%2B3,3&format=csv");
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 200);
    EXPECT_EQ(answer->get_header_value("Content-Type"), "text/csv");
    EXPECT_EQ(std::count(answer->body.begin(), answer->body.end(), '\n'), 1 + 4);
    const auto wrong = client.Get("/api/history?limit=many");
    EXPECT_EQ(wrong->status, 400);
    EXPECT_NE(wrong->body.find("'many' is no limit"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
