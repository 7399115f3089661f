// The history through databases that vanish and come back.
#include "roomfix/pipeline/history_sink.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <thread>

#include "pipeline/postgres_server.hpp"
#include "temporary_folder.hpp"

namespace roomfix {
namespace {

class StoredHistory : public TemporaryFolder {};

std::unique_ptr<HistorySink> sink_to(const std::string& database, HistorySettings settings = {}) {
    settings.interval = 0.1;
    auto store = FixStore::open(database, "lab", 1);
    return std::make_unique<HistorySink>(std::move(*store), settings);
}

FixBatch one_fix(Nanoseconds time) {
    Fix fix;
    fix.time = time;
    fix.robot = "r1";
    fix.status = FixStatus::ok;
    fix.sources = {"hall"};
    return {time, {fix}, {}};
}

/// What is not true within a minute never will be.
bool becomes_true(const std::function<bool()>& condition) {
    for (int i = 0; i < 6000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return condition();
}

std::vector<Fix> all_of(const std::string& database) {
    const auto fixes = (*FixStore::open(database, "lab"))->find({.limit = 1000000, .newest_first = false});
    EXPECT_TRUE(fixes) << fixes.error().message;
    return fixes ? *fixes : std::vector<Fix>();
}

TEST_F(StoredHistory, WhatIsOlderThanTheNewestByMoreThanTheDaysIsDeleted) {
    const std::string database = (folder / "history.db").string();
    const Nanoseconds now = from_seconds(1.7e9);
    {
        auto sink = sink_to(database);
        for (int day = 0; day < 10; ++day) ASSERT_TRUE(sink->give(one_fix(now - from_seconds(86400.0 * day))));
        ASSERT_TRUE(sink->finish());
    }
    EXPECT_EQ(all_of(database).size(), 10U);
    HistorySettings settings;
    settings.days = 3.5;
    auto sink = std::make_unique<HistorySink>(std::move(*FixStore::open(database, "lab", 2)), settings);
    ASSERT_TRUE(sink->give(one_fix(now)));
    ASSERT_TRUE(sink->finish());
    EXPECT_EQ(all_of(database).size(), 5U);
}

TEST_F(StoredHistory, WithoutADatabaseTheOldestAreLostAndCounted) {
    HistorySettings settings;
    settings.most_waiting = 100;
    auto sink = sink_to((folder / "missing" / "history.db").string(), settings);
    for (int i = 0; i < 250; ++i) {
        FixBatch batch = one_fix(i);
        batch.zone_events.push_back({});
        ASSERT_TRUE(sink->give(batch));
    }
    EXPECT_TRUE(becomes_true([&] { return !sink->stored().ok; }));
    EXPECT_GE(sink->stored().fixes.lost, 50);
    EXPECT_GE(sink->stored().zone_events.lost, 50);
    const auto finished = sink->finish();
    ASSERT_FALSE(finished);
    EXPECT_EQ(finished.error().message.find("250 fixes and 250 events of zones are missing in the history: history "), 0U) << finished.error().message;
}

TEST_F(StoredHistory, AFolderThatAppearsLaterGetsAll) {
    std::atomic<int> told = 0;
    HistorySettings settings;
    settings.on_trouble = [&](const std::string&) { ++told; };
    auto sink = sink_to((folder / "disk" / "history.db").string(), settings);
    ASSERT_TRUE(sink->give(one_fix(1)));
    ASSERT_TRUE(becomes_true([&] { return told == 1; }));
    std::filesystem::create_directories(folder / "disk");
    ASSERT_TRUE(becomes_true([&] { return told == 2; }));
    EXPECT_TRUE(sink->finish());
    EXPECT_EQ(all_of((folder / "disk" / "history.db").string()).size(), 1U);
}

TEST_F(StoredHistory, APostgresqlServerThatIsKilledUnderLoadMissesNothingAndHasNothingTwice) {
    if (PostgresServer::programs().empty()) GTEST_SKIP() << "no PostgreSQL server here";
    PostgresServer server(folder / "postgres");
    ASSERT_TRUE(server.made());
    std::atomic<bool> stop = false;
    std::atomic<std::int64_t> given = 0;
    auto created = FixStore::open(server.address(), "lab", 1);
    if (!created) GTEST_SKIP() << created.error().message;
    HistorySink sink(std::move(*created), {.interval = 0.1});
    std::thread load([&] {
        while (!stop) {
            EXPECT_TRUE(sink.give(one_fix(given + 1)));
            ++given;
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
    });
    EXPECT_TRUE(becomes_true([&] { return !sink.stored().ok; })) << "it is not there yet";
    for (int round = 0; round < 2; ++round) {
        EXPECT_TRUE(server.start());
        const std::int64_t before = sink.stored().fixes.stored;
        EXPECT_TRUE(becomes_true([&] { return sink.stored().ok && sink.stored().fixes.stored > before; }));
        server.stop();
        EXPECT_TRUE(becomes_true([&] { return !sink.stored().ok; }));
    }
    EXPECT_TRUE(server.start());
    stop = true;
    load.join();
    EXPECT_TRUE(becomes_true([&] { return sink.stored().fixes.waiting == 0; }));
    const auto finished = sink.finish();
    EXPECT_TRUE(finished) << finished.error().message;
    const std::vector<Fix> stored = all_of(server.address());
    ASSERT_EQ(static_cast<std::int64_t>(stored.size()), given.load());
    for (std::size_t i = 0; i < stored.size(); ++i) ASSERT_EQ(stored[i].time, static_cast<Nanoseconds>(i + 1));
}

TEST_F(StoredHistory, AWrongPostgresqlPasswordIsSaidWithoutThePassword) {
    auto store = FixStore::open("postgresql://u:very%20secret@[::1/postgres", "lab");
    if (!store) GTEST_SKIP() << store.error().message;
    const auto found = (*store)->find({});
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().message.find("secret"), std::string::npos) << found.error().message;
    EXPECT_NE(found.error().message.find("PGPASSWORD"), std::string::npos) << found.error().message;
}

}  // namespace
}  // namespace roomfix
