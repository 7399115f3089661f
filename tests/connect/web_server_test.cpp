// The page's server: who may change what, what it describes of itself, and zones that go into a site file.
#include "roomfix/connect/web_server.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "roomfix/connect/plan_picture.hpp"
#include "roomfix/connect/web_routes.hpp"
#include "roomfix/connect/zone_answer.hpp"
#include "roomfix/site/load_site.hpp"

namespace roomfix {
namespace {

const WebAccess access_of_both = {"127.0.0.1", 0, "", "", "look", "change"};

TEST(WebRoutes, AreThoseThatAreDescribed) {
    std::set<std::string> described;
    const auto description = nlohmann::json::parse(openapi_text());
    for (const auto& [path, item] : description["paths"].items()) {
        for (const auto& [method, operation] : item.items()) {
            std::string name = method;
            std::transform(name.begin(), name.end(), name.begin(), [](char c) { return static_cast<char>(c - 'a' + 'A'); });
            described.insert(name + " " + path);
        }
    }
    EXPECT_EQ(described, std::set<std::string>(web_routes.begin(), web_routes.end()));
}

TEST(WebRoutes, NamesInThemAreIds) {
    EXPECT_EQ(id_in("/api/cameras/hall-1.jpg", "GET /api/cameras/{id}.jpg"), "hall-1");
    EXPECT_EQ(id_in("/api/site", "GET /api/site"), "");
    for (const char* path :
         {"/api/cameras/.jpg", "/api/cameras/a/b.jpg", "/api/cameras/hall-1", "/api/cameras/../x.jpg", "/api/cameras/a%20b.jpg", "/api/cameras"}) {
        EXPECT_FALSE(id_in(path, "GET /api/cameras/{id}.jpg")) << path;
    }
    EXPECT_FALSE(id_in("/api/zones/" + std::string(65, 'a'), "PUT /api/zones/{id}"));
}

TEST(WebAccess, TheRoleIsThatOfTheToken) {
    EXPECT_EQ(role_of(access_of_both, "Bearer look"), WebRole::viewer);
    EXPECT_EQ(role_of(access_of_both, "Bearer change"), WebRole::operating);
    EXPECT_EQ(role_of(access_of_both, "Basic bWU6Y2hhbmdl"), WebRole::operating);  // me:change
    for (const char* wrong : {"", "Bearer ", "Bearer chang", "change", "Basic bWU6", "Basic Y2hhbmdl"})
        EXPECT_EQ(role_of(access_of_both, wrong), WebRole::nobody);
    EXPECT_EQ(role_of({}, ""), WebRole::viewer);
    EXPECT_EQ(role_of({}, "Bearer "), WebRole::viewer) << "without an operator's token an empty one makes nobody an operator";
}

TEST(WebAccess, TheOperatorsTokenIsNotThatOfViewers) {
    ASSERT_EQ(setenv("ROOMFIX_TEST_TOKEN", "same", 1), 0);
    WebOutput web;
    web.token = web.operator_token = Secret{"", "ROOMFIX_TEST_TOKEN"};
    const auto access = web_access(web, {}, "the page");
    ASSERT_FALSE(access);
    EXPECT_NE(access.error().message.find("make another one"), std::string::npos);
    EXPECT_EQ(access.error().message.find("same"), std::string::npos) << "secrets are not told";
    web.token.reset();
    EXPECT_EQ(web_access(web, {}, "the page")->operator_token, "same");
}

TEST(WebAccess, AnotherSitesPageChangesNothing) {
    EXPECT_EQ(foreign_change({"", "a:80", "application/json"}), "");
    EXPECT_EQ(foreign_change({"http://a:80", "a:80", "application/json; charset=utf-8"}), "");
    EXPECT_EQ(foreign_change({"http://a:80", "a:80", std::nullopt}), "");
    EXPECT_NE(foreign_change({"http://b:80", "a:80", "application/json"}), "");
    EXPECT_NE(foreign_change({"null", "a:80", std::nullopt}), "");
    EXPECT_NE(foreign_change({"http://a:8", "a:80", std::nullopt}), "");
    for (const char* type : {"text/plain", "", "application/x-www-form-urlencoded", "application/jsonx"})
        EXPECT_NE(foreign_change({"", "a:80", type}), "") << type;
}

/// A server whose only zone can be changed, and what came to it.
class Changes : public ::testing::Test {
protected:
    void serve(const WebAccess& access) {
        server.add_route("PUT /api/zones/{id}", [this](const WebQuestion& question) {
            changed.push_back(question.id + " " + question.body);
            return WebAnswer{204, "text/plain", ""};
        });
        ASSERT_TRUE(server.start(access));
        client = std::make_unique<httplib::Client>("127.0.0.1", server.port());
    }
    int put(const httplib::Headers& headers, const std::string& body = "{}", const std::string& path = "/api/zones/dock") {
        const auto answer = client->Put(path, headers, body, "application/json");
        return answer ? answer->status : 0;
    }
    /// The first line of the answer to a request that no client would send.
    std::string raw(const std::string& request) {
        const int peer = ::socket(AF_INET, SOCK_STREAM, 0);
        sockaddr_in address = {};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(server.port()));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        if (::connect(peer, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return "no connection";
        (void)!::write(peer, request.data(), request.size());
        std::string answer;
        char buffer[4096];
        for (ssize_t n = 0; (n = ::read(peer, buffer, sizeof buffer)) > 0;) answer.append(buffer, static_cast<std::size_t>(n));
        ::close(peer);
        return answer;
    }

    const httplib::Headers operating = {{"Authorization", "Bearer change"}};
    std::vector<std::string> changed;
    WebServer server;
    std::unique_ptr<httplib::Client> client;
};

TEST_F(Changes, AreTheOperatorsAlone) {
    serve(access_of_both);
    EXPECT_EQ(put({}), 401);
    EXPECT_EQ(put({{"Authorization", "Bearer look"}}), 403);
    EXPECT_TRUE(changed.empty());
    EXPECT_EQ(put(operating, R"({"a": 1})"), 204);
    ASSERT_EQ(changed.size(), 1U);
    EXPECT_EQ(changed[0], R"(dock {"a": 1})");
    EXPECT_EQ(client->Get("/api/access", {{"Authorization", "Bearer look"}})->body, R"({"role":"viewer","operators":true})");
    EXPECT_EQ(client->Get("/api/access", operating)->body, R"({"role":"operator","operators":true})");
}

TEST_F(Changes, AreNobodysWithoutAnOperator) {
    serve({"127.0.0.1", 0});
    const auto answer = client->Put("/api/zones/dock", "{}", "application/json");
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 403);
    EXPECT_NE(answer->body.find("outputs.web.operator"), std::string::npos);
    EXPECT_TRUE(changed.empty());
    EXPECT_EQ(client->Get("/api/access")->body, R"({"role":"viewer","operators":false})");
}

TEST_F(Changes, ComeFromThePageItself) {
    serve({"127.0.0.1", 0, "", "", "", "change"});
    EXPECT_EQ(put({}), 401) << "whoever may look is no operator";
    httplib::Headers foreign = operating;
    foreign.emplace("Origin", "http://elsewhere.example");
    EXPECT_EQ(put(foreign), 403);
    EXPECT_EQ(client->Put("/api/zones/dock", operating, "{}", "text/plain")->status, 403);
    EXPECT_EQ(client->Options("/api/zones/dock")->status, 404) << "nobody is told that more is allowed";
    EXPECT_TRUE(changed.empty());
    httplib::Headers own = operating;
    own.emplace("Origin", fmt::format("http://127.0.0.1:{}", server.port()));
    EXPECT_EQ(put(own), 204);
}

TEST_F(Changes, AreOfLimitedSize) {
    serve({"127.0.0.1", 0, "", "", "", "change"});
    EXPECT_EQ(put(operating, std::string(64 * 1024 + 1, ' ')), 413);
    const std::string head = "PUT /api/zones/dock HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer change\r\nContent-Type: application/json\r\n";
    for (const char* more : {"Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n", "Content-Encoding: gzip\r\nContent-Length: 2\r\n\r\n{}", "\r\n{}"}) {
        const std::string answer = raw(head + more);
        EXPECT_EQ(answer.substr(0, 12), "HTTP/1.1 411") << more;
        EXPECT_EQ(answer.find("HTTP/1.1", 5), std::string::npos) << "what comes behind is no request of its own";
    }
    EXPECT_TRUE(changed.empty());
    EXPECT_EQ(client->Post("/api/zones/dock", operating, "{}", "application/json")->status, 405);
    const auto wrong = client->Delete("/api/zones/dock", operating);
    EXPECT_EQ(wrong->status, 405);
    EXPECT_EQ(wrong->get_header_value("Allow"), "PUT");
    EXPECT_EQ(put(operating, "{}", "/api/zones/a%20b"), 404);
}

TEST(ZoneBorder, IsReadAsTheSiteFilesZonesAre) {
    const auto border = parse_zone_border(R"({"border": [[0, 0], [1.23456, 0], [1, 2e0]]})");
    ASSERT_TRUE(border) << border.error().message;
    EXPECT_EQ((*border)[1], Eigen::Vector2d(1.235, 0));
    const std::pair<const char*, const char*> mistakes[] = {{"", "a zone is"},
                                                            {"[]", "a zone is"},
                                                            {R"({"border": [[0, 0], [1, 0], [0, 1]], "name": "x"})", "a zone is"},
                                                            {R"({"border": 7})", "a zone is"},
                                                            {R"({"border": [[0, 0], [1, "0"], [0, 1]]})", "corner 2"},
                                                            {R"({"border": [[0, 0], [1, 0], [0, 1e6]]})", "corner 3"},
                                                            {R"({"border": [[0, 0], [1, 0], [0, 1e999]]})", "a zone is"},
                                                            {R"({"border": [[0, 0, 0], [1, 0], [0, 1]]})", "corner 1"},
                                                            {R"({"border": [[0, 0], [1, 0]]})", "three or more"},
                                                            {R"({"border": [[0, 0], [2, 0], [0, 2], [2, 2]]})", "crosses"}};
    for (const auto& [text, words] : mistakes) {
        const auto read = parse_zone_border(text);
        ASSERT_FALSE(read) << text;
        EXPECT_NE(read.error().message.find(words), std::string::npos) << text << ": " << read.error().message;
    }
}

class SiteFile : public ::testing::Test {
protected:
    void SetUp() override { std::filesystem::create_directories(folder); }
    void TearDown() override { std::filesystem::remove_all(folder); }
    void write(const std::string& text) { std::ofstream(file) << text; }
    std::string text(const std::string& of = "site.yaml") {
        std::ifstream stream(folder / of);
        return {std::istreambuf_iterator<char>(stream), {}};
    }
    WebAnswer put(const std::string& id, const std::string& border) { return editor.put({{}, id, R"({"border": )" + border + "}"}); }

    std::filesystem::path folder = std::filesystem::temp_directory_path() / fmt::format("roomfix_zones_{}", getpid());
    std::filesystem::path file = folder / "site.yaml";
    ZoneEditor editor{file};
};

TEST_F(SiteFile, TakesZonesAndKeepsAllElse) {
    const std::string before =
        "roomfix: 1  # ours\nsite: {name: hall}\nzones:\n  dock: [[0, 0], [1, 0], [0, 1]]  # the old one\nrobots:\n  r: {shape: box, size: [1, 1, 1]}\n";
    write(before);
    const WebAnswer made = put("gate", "[[5, 5], [6, 5], [6, 6.0004]]");
    EXPECT_EQ(made.status, 200) << made.body;
    EXPECT_EQ(made.body, R"({"border":[[5.0,5.0],[6.0,5.0],[6.0,6.0]],"id":"gate"})");
    EXPECT_EQ(text("site.yaml~"), before);
    EXPECT_NE(text().find("# the old one\n  gate: [[5, 5], [6, 5], [6, 6]]\nrobots:"), std::string::npos) << text();
    EXPECT_EQ(put("dock", "[[0, 0], [2, 0], [0, 2]]").status, 200);
    EXPECT_NE(text().find("  dock: [[0, 0], [2, 0], [0, 2]]  # the old one\n"), std::string::npos) << text();
    EXPECT_EQ(editor.remove({{}, "dock"}).status, 204);
    EXPECT_EQ(editor.remove({{}, "dock"}).status, 404);
    EXPECT_EQ(editor.remove({{}, "gate"}).status, 204);
    EXPECT_EQ(text(), "roomfix: 1  # ours\nsite: {name: hall}\nrobots:\n  r: {shape: box, size: [1, 1, 1]}\n");
}

TEST_F(SiteFile, StaysWhereItWouldNotBeRightAfterwards) {
    for (const std::string before : {"roomfix: 1\nsite: {name: hall}\nzones: &all {dock: [[0, 0], [1, 0], [0, 1]]}\nrobots: nonsense\n",  // has mistakes
                                     "roomfix: 1\nsite: {name: hall}\nzones:\n  ? dock\n  : [[0, 0], [1, 0], [0, 1]]\n"}) {  // a key as nobody writes it
        write(before);
        const WebAnswer answer = put("dock", "[[0, 0], [2, 0], [0, 2]]");
        if (answer.status == 200) continue;  // it was written, and was right
        EXPECT_EQ(answer.status, 409) << answer.body;
        EXPECT_EQ(text(), before);
    }
    write("roomfix: 1\nsite: {name: hall}\nzones: &all {dock: &c [[0, 0], [1, 0], [0, 1]], gate: *c}\n");
    const std::string before = text();
    EXPECT_EQ(put("dock", "[[0, 0], [2, 0], [0, 2]]").status, 409) << text();  // what *c means would be gone
    EXPECT_EQ(text(), before);
    EXPECT_EQ(put("dock", "[]").status, 400);
}

TEST_F(SiteFile, APlansPictureBecomesPng) {
    const auto grey = [](const PlanPicture& picture, int x, int y) {
        const std::vector<char> bytes(picture.png.begin(), picture.png.end());
        return static_cast<int>(cv::imdecode(bytes, cv::IMREAD_GRAYSCALE).at<unsigned char>(y, x));
    };
    std::ofstream(folder / "map.pgm", std::ios::binary) << "P5\n3 2\n255\n" << std::string("\x00\xcd\xfe\x01\x02\x03", 6);
    Site site;
    site.folder = folder;
    site.plan = SitePlan{"map.pgm", 0.05, {}};
    const auto plain = load_plan_picture(site, *site.plan);
    ASSERT_TRUE(plain) << plain.error().message;
    EXPECT_EQ(plain->width, 3);
    EXPECT_EQ(plain->height, 2);
    EXPECT_EQ(grey(*plain, 1, 0), 0xcd);
    std::ofstream(folder / "map.yaml") << "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 1\n";
    site.plan->image = "map.yaml";
    EXPECT_EQ(grey(*load_plan_picture(site, *site.plan), 1, 0), 255 - 0xcd);
    std::ofstream(folder / "map.png", std::ios::binary) << plain->png;
    site.plan->image = "map.png";
    EXPECT_EQ(load_plan_picture(site, *site.plan)->png, plain->png) << "a PNG stays as it is";
    std::ofstream(folder / "map.png", std::ios::binary) << plain->png.substr(0, 40);
    const auto damaged = load_plan_picture(site, *site.plan);
    ASSERT_FALSE(damaged);
    EXPECT_NE(damaged.error().message.find("map.png: is damaged"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
