#include "roomfix/connect/zone_answer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>

#include "roomfix/base/text_file.hpp"
#include "roomfix/connect/json_text.hpp"
#include "roomfix/site/edit_site.hpp"
#include "roomfix/site/load_site.hpp"
#include "roomfix/site/read_zone.hpp"
#include "roomfix/site/site_text.hpp"

namespace roomfix {
namespace {

using nlohmann::json;

constexpr double farthest_corner = 1e5;  // m, as in the site file
constexpr const char* expected = R"(a zone is {"border": [[x, y], ...]}, m on the map)";

std::optional<Eigen::Vector2d> corner_of(const json& corner) {
    if (!corner.is_array() || corner.size() != 2 || !corner[0].is_number() || !corner[1].is_number()) return std::nullopt;
    const Eigen::Vector2d p(corner[0].get<double>(), corner[1].get<double>());
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() > farthest_corner) return std::nullopt;
    return Eigen::Vector2d(std::round(p.x() * 1e3) / 1e3, std::round(p.y() * 1e3) / 1e3);
}

/// All fatal problems, each on a line.
std::string problems_of(const LoadedSite& loaded) {
    std::string all;
    for (const Problem& problem : loaded.problems) {
        if (problem.fatal) all += fmt::format("line {}: {}\n", problem.line, problem.message);
    }
    return all;
}

auto zone_in(Site& site, const std::string& id) {
    return std::find_if(site.zones.begin(), site.zones.end(), [&](const SiteZone& zone) { return zone.id == id; });
}

}  // namespace

Result<Polyline> parse_zone_border(std::string_view text) {
    const json zone = json::parse(text, nullptr, false);
    if (!zone.is_object() || zone.size() != 1 || !zone.contains("border") || !zone["border"].is_array()) return Error{expected};
    Polyline border;
    for (const json& corner : zone["border"]) {
        const auto p = corner_of(corner);
        if (!p) return Error{fmt::format("corner {} is not two numbers: {}", border.size() + 1, expected)};
        border.push_back(*p);
    }
    if (const std::string problem = border_problem(border); !problem.empty()) return Error{"the zone " + problem};
    return border;
}

struct ZoneEditor::Impl {
    std::filesystem::path file;
    std::mutex mutex;  // held while the file is read and written

    WebAnswer change(const std::string& id, const Polyline& border);
};

/// An empty border removes the zone.
WebAnswer ZoneEditor::Impl::change(const std::string& id, const Polyline& border) {
    const std::lock_guard lock(mutex);
    const auto text = read_text(file);
    if (!text) return {500, "text/plain", text.error().message + "\n"};
    const std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
    LoadedSite before = parse_site(*text, folder);
    if (!before.usable()) return {409, "text/plain", "the site file has mistakes just now; correct them first:\n" + problems_of(before)};
    Site wanted = before.site;
    const auto zone = zone_in(wanted, id);
    if (border.empty()) {
        if (zone == wanted.zones.end()) return {404, "text/plain", fmt::format("there is no zone '{}'\n", id)};
        wanted.zones.erase(zone);
    } else if (zone != wanted.zones.end()) {
        zone->border = border;
    } else {
        wanted.zones.push_back({id, border});
    }
    const auto changed = with_entry(*text, "zones", {id, border.empty() ? "" : points_text(border)});
    const LoadedSite after = changed ? parse_site(*changed, folder) : LoadedSite{};
    if (!changed || !after.usable() || site_text(after.site) != site_text(wanted)) {
        return {409, "text/plain", "the site file is written in a way that cannot be changed from here: write the zone into it by hand\n"};
    }
    std::error_code failure;
    const auto written = replace_file(file, *changed, std::filesystem::weakly_canonical(file, failure).string() + "~");
    return written ? WebAnswer{204, "text/plain", ""} : WebAnswer{500, "text/plain", written.error().message + "\n"};
}

ZoneEditor::ZoneEditor(std::filesystem::path site_file) : impl_(std::make_unique<Impl>()) { impl_->file = std::move(site_file); }
ZoneEditor::~ZoneEditor() = default;
ZoneEditor::ZoneEditor(ZoneEditor&&) noexcept = default;

WebAnswer ZoneEditor::put(const WebQuestion& question) {
    const auto border = parse_zone_border(question.body);
    if (!border) return {400, "text/plain", border.error().message + "\n"};
    WebAnswer answer = impl_->change(question.id, *border);
    if (answer.status != 204) return answer;
    json zone = {{"id", question.id}, {"border", json::array()}};
    for (const Eigen::Vector2d& p : *border) zone["border"].push_back({p.x(), p.y()});
    return {200, "application/json", json_line(zone)};
}

WebAnswer ZoneEditor::remove(const WebQuestion& question) { return impl_->change(question.id, {}); }

}  // namespace roomfix
