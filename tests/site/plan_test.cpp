// The picture of a site from above: what its files may say, and what is told where they say something else.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "roomfix/site/load_site.hpp"
#include "roomfix/site/read_plan.hpp"
#include "roomfix/site/read_zone.hpp"
#include "roomfix/site/site_text.hpp"

namespace roomfix {
namespace {

class Plan : public ::testing::Test {
protected:
    void SetUp() override {
        std::filesystem::create_directories(folder / "maps");
        write("maps/hall.pgm", "P5\n# made by map_saver 0.050 m/pix\n4 2\n255\n" + std::string(8, '\xfe'));
    }
    void TearDown() override { std::filesystem::remove_all(folder); }
    void write(const std::string& name, const std::string& content) { std::ofstream(folder / name, std::ios::binary) << content; }
    LoadedSite with_plan(const std::string& value) { return parse_site("roomfix: 1\nsite: {name: hall}\nplan: " + value + "\n", folder); }
    /// The one mistake in it, "LINE:COLUMN message".
    std::string mistake(const std::string& value) {
        const LoadedSite loaded = with_plan(value);
        std::string told;
        for (const Problem& p : loaded.problems) told += fmt::format("{}:{} {}", p.line, p.column, p.message);
        return told;
    }
    void expect_mistake(const std::string& value, const std::string& words) {
        const std::string told = mistake(value);
        EXPECT_NE(told.find(words), std::string::npos) << value << " gives: " << told;
        EXPECT_EQ(told.substr(0, 2), "3:") << told;
    }

    std::filesystem::path folder = std::filesystem::temp_directory_path() / fmt::format("roomfix_plan_{}", getpid());
};

TEST_F(Plan, IsReadAndWrittenAgain) {
    write("maps/hall.yaml", "image: hall.pgm\nmode: trinary\nresolution: 0.1\norigin: [-1.5, 2, 0.5]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n");
    for (const char* value : {"maps/hall.yaml", "{image: maps/hall.pgm, resolution: 0.1, origin: [-1.5, 2, 28.64788975654116]}"}) {
        const LoadedSite first = with_plan(value);
        for (const auto& p : first.problems) EXPECT_FALSE(p.fatal) << p.message;
        for (const Site& site : {first.site, parse_site(site_text(first.site), folder).site}) {
            ASSERT_TRUE(site.plan);
            EXPECT_EQ(site.plan->resolution, 0.1);
            EXPECT_EQ(site.plan->map_from_plan.x, -1.5);
            EXPECT_EQ(site.plan->map_from_plan.y, 2);
            EXPECT_NEAR(site.plan->map_from_plan.yaw, 0.5, 1e-12);
        }
    }
    EXPECT_EQ(with_plan("{image: maps/hall.pgm, resolution: 0.1}").site.plan->map_from_plan.yaw, 0);
    EXPECT_FALSE(parse_site("roomfix: 1\nsite: {name: hall}\n", folder).site.plan);
}

TEST_F(Plan, WhatCannotBeShownIsToldWithItsPlace) {
    expect_mistake("{image: maps/none.png, resolution: 0.1}", "none.png: cannot be read");
    expect_mistake("{image: maps, resolution: 0.1}", "cannot be read");
    expect_mistake("{image: maps/hall.pgm, resolution: 0}", "plan.resolution must lie between 0.0001 and 10");
    expect_mistake("{image: maps/hall.pgm}", "needs the key 'resolution'");
    expect_mistake("{image: maps/hall.pgm, resolution: 0.1, origin: [1, 2]}", "plan.origin");
    expect_mistake("{image: maps/hall.pgm, resolution: 0.1, origin: [1, 2, 400]}", "in degrees");
    expect_mistake("maps/hall.pgm", "map.yaml, or {image:");
    write("picture.png", "GIF89a");
    expect_mistake("{image: picture.png, resolution: 0.1}", "no PNG, PGM or PPM");
    write("wide.pgm", "P5 100000 10 255\n");
    expect_mistake("{image: wide.pgm, resolution: 0.1}", "100000 x 10 pixels");
    write("odd.pgm", "P5 # a comment without an end");
    expect_mistake("{image: odd.pgm, resolution: 0.1}", "no PNG, PGM or PPM");
}

TEST_F(Plan, AMapFilesMistakesAreToldWithItsLine) {
    const auto expect = [&](const std::string& text, const std::string& words) {
        write("map.yaml", text);
        expect_mistake("map.yaml", words);
    };
    expect_mistake("map.yaml", "map.yaml");  // not there
    expect("image: maps/hall.pgm\nresolution: 0.05\norigin: [0, 0, .nan]\n", "map.yaml: line 3: 'origin'");
    expect("image: maps/hall.pgm\nresolution: -1\norigin: [0, 0, 0]\n", "line 2: 'resolution'");
    expect("resolution: 0.05\norigin: [0, 0, 0]\n", "'image'");
    expect("image: maps/hall.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: perhaps\n", "line 4: 'negate'");
    expect("image: none.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n", "none.pgm: cannot be read");
    expect("[", "not valid YAML");
    expect("just words", "no map file");
    EXPECT_TRUE(parse_map_file("image: a\nresolution: 1e-1\norigin: [0, 0, 0]\nnegate: 1")->negate);
}

TEST(Zone, ABorderThatEnclosesNothingIsAMistake) {
    EXPECT_EQ(border_problem({{0, 0}, {2, 0}, {2, 2}, {0, 2}}), "");
    EXPECT_EQ(border_problem({{0, 0}, {2, 1}, {0, 2}, {1, 1}}), "") << "a corner may point inward";
    EXPECT_NE(border_problem({{0, 0}, {2, 0}, {0, 2}, {2, 2}}).find("crosses"), std::string::npos);
    EXPECT_NE(border_problem({{0, 0}, {1, 1}, {2, 2}}).find("no area"), std::string::npos);
    EXPECT_NE(border_problem({{0, 0}, {1, 1}}).find("three or more"), std::string::npos);
    EXPECT_NE(border_problem(Polyline(201, {1, 1})).find("enough"), std::string::npos);
    const LoadedSite loaded = parse_site("roomfix: 1\nsite: {name: hall}\nzones:\n  bow: [[0, 0], [2, 0], [0, 2], [2, 2]]\n", "/");
    ASSERT_EQ(loaded.problems.size(), 1U);
    EXPECT_EQ(loaded.problems[0].line, 4);
    EXPECT_NE(loaded.problems[0].message.find("zones.bow crosses its own border"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
