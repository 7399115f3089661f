#include "roomfix/site/outputs.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "roomfix/site/load_site.hpp"
#include "roomfix/site/site_text.hpp"

namespace roomfix {
namespace {

LoadedSite with_outputs(const std::string& lines) { return parse_site("roomfix: 1\nsite: {name: hall}\n" + lines, "/somewhere"); }

bool complains(const LoadedSite& loaded, const std::string& of) {
    return std::any_of(loaded.problems.begin(), loaded.problems.end(), [&](const Problem& p) { return p.fatal && p.message.find(of) != std::string::npos; });
}

TEST(Outputs, AreReadAndWrittenAgain) {
    const LoadedSite first = with_outputs(
        "zones: {dock: [[0, 0], [1, 0], [1, 2.5]]}\n"
        "outputs:\n"
        "  jsonl: 'it''s.jsonl'\n"
        "  tum: ways\n"
        "  web: {host: 0.0.0.0, port: 81, tls: {certificate: a.crt, key: a.key}, token: {env: PAGE_TOKEN}, operator: {file: op}}\n"
        "  foxglove: {port: 0}\n"
        "  mqtt: {host: broker, prefix: a/b, user: u, password: {file: secret}, tls: {ca: ca.crt}, rate: 2.5, home_assistant: true}\n"
        "  ros2: {domain: 7, robot_transform: true}\n"
        "  history: {database: 'postgresql://h/d', days: 1.5}\n");
    for (const auto& p : first.problems) EXPECT_FALSE(p.fatal) << p.message;
    for (const Site& site : {first.site, parse_site(site_text(first.site), "/somewhere").site}) {
        const Outputs& out = site.outputs;
        ASSERT_EQ(site.zones.size(), 1U);
        EXPECT_EQ(site.zones[0].border[2], Eigen::Vector2d(1, 2.5));
        EXPECT_EQ(out.jsonl, "it's.jsonl");
        EXPECT_EQ(out.tum, "ways");
        ASSERT_TRUE(out.web && out.web->tls && out.web->token && out.mqtt && out.mqtt->tls && out.mqtt->password && out.ros2 && out.history && out.foxglove);
        EXPECT_EQ(out.web->tls->key, "a.key");
        EXPECT_EQ(out.web->token->variable, "PAGE_TOKEN");
        ASSERT_TRUE(out.web->operator_token);
        EXPECT_EQ(out.web->operator_token->file, "op");
        EXPECT_EQ(out.foxglove->port, 0);
        EXPECT_EQ(out.mqtt->port, 8883);  // of TLS
        EXPECT_EQ(out.mqtt->prefix, "a/b");
        EXPECT_EQ(out.mqtt->password->file, "secret");
        EXPECT_EQ(out.mqtt->rate, 2.5);
        EXPECT_TRUE(out.mqtt->home_assistant);
        EXPECT_EQ(out.ros2->domain, 7);
        EXPECT_TRUE(out.ros2->robot_transform);
        EXPECT_EQ(out.history->database, "postgresql://h/d");
        EXPECT_EQ(out.history->days, 1.5);
    }
}

TEST(Outputs, WhatCannotWorkIsTold) {
    EXPECT_TRUE(complains(with_outputs("outputs: {web: {host: 0.0.0.0}}"), "everybody"));
    EXPECT_TRUE(complains(with_outputs("outputs: {foxglove: {host: '::', token: {env: A}}}"), "everybody"));
    EXPECT_FALSE(complains(with_outputs("outputs: {web: {host: 0.0.0.0, insecure: true}}"), ""));
    EXPECT_TRUE(complains(with_outputs("outputs: {web: {token: secret}}"), "does not stand in the site file"));
    EXPECT_TRUE(complains(with_outputs("outputs: {web: {token: {file: a, env: b}}}"), "one of file and env"));
    EXPECT_TRUE(complains(with_outputs("outputs: {web: {operator: secret}}"), "outputs.web.operator does not stand in the site file"));
    EXPECT_TRUE(complains(with_outputs("outputs: {web: {host: 0.0.0.0, insecure: true, operator: {env: A}}}"), "everybody to read"));
    EXPECT_FALSE(complains(with_outputs("outputs: {web: {operator: {env: A}}}"), "")) << "this machine only";
    EXPECT_TRUE(complains(with_outputs("outputs: {foxglove: {operator: {env: A}}}"), "no key 'operator'"));
    EXPECT_TRUE(complains(with_outputs("outputs: {mqtt: {prefix: 'a/#'}}"), "beginning of a topic"));
    EXPECT_TRUE(complains(with_outputs("outputs: {mqtt: {password: {env: A}}}"), "no user"));
    EXPECT_TRUE(complains(with_outputs("outputs: {mqtt: {tls: {certificate: a}}}"), "come together"));
    EXPECT_TRUE(complains(with_outputs("outputs: {mqtt: {home_assistant: perhaps}}"), "true or false"));
    EXPECT_TRUE(complains(with_outputs("outputs: {history: {days: 0}}"), "days"));
    EXPECT_TRUE(complains(with_outputs("zones: {dock: [[0, 0], [1, 0]]}"), "three or more"));
}

}  // namespace
}  // namespace roomfix
