#include "roomfix/pipeline/session_content.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "roomfix/base/text_file.hpp"
#include "roomfix/pipeline/background_source.hpp"
#include "roomfix/site/edit_site.hpp"
#include "roomfix/site/load_site.hpp"
#include "roomfix/site/outputs_text.hpp"
#include "roomfix/site/site_text.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

/// The files of a folder by their names, or the file itself.
std::vector<fs::path> files_of(const fs::path& source) {
    std::error_code failure;
    if (!fs::is_directory(source, failure)) return {source};
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(source, failure)) {
        if (entry.is_regular_file(failure)) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

/// A camera's background, copied to a folder of the session, or to a file where it is one. Several folders become one, in their order.
std::string copy_background(const std::string& camera, const std::vector<std::string>& sources, std::vector<CopiedFile>& files) {
    const fs::path folder = fs::path("background") / camera;
    std::error_code failure;
    if (sources.size() == 1 && !fs::is_directory(sources[0], failure)) {
        const fs::path to = folder.string() + fs::path(sources[0]).extension().string();
        files.push_back({sources[0], to});
        return to.string();
    }
    int number = 0;
    for (const std::string& source : sources) {
        for (const fs::path& file : files_of(source)) {
            const std::string name = sources.size() == 1 ? file.filename().string() : fmt::format("{:06}{}", ++number, file.extension().string());
            files.push_back({file, folder / name});
        }
    }
    return folder.string();
}

/// Where everything of a camera lies in a session.
SiteEdit camera_edit(SiteCamera& camera, const Site& site, const std::vector<std::string>& background, std::vector<CopiedFile>& files) {
    camera.source = "frames/" + camera.id;
    SiteEdit edit{camera.id, {{"source", camera.source}}};
    if (!camera.lens_grid.empty()) {
        const fs::path to = fmt::format("lens/{}{}", camera.id, fs::path(camera.lens_grid).extension().string());
        files.push_back({resolved_path(site, camera.lens_grid), to});
        camera.lens_grid = to.string();
        edit.values.push_back({"lens_grid", camera.lens_grid});
    }
    const std::vector<std::string> sources = background_sources(site, camera, background);
    if (!sources.empty()) {
        camera.background = copy_background(camera.id, sources, files);
        edit.values.push_back({"background", camera.background});
    }
    return edit;
}

/// A model that needs more files than one (a URDF with its meshes) goes as the parts that it was made of.
void move_model(SiteRobot& robot, const Site& site, SiteEdit& edit, std::vector<CopiedFile>& files) {
    if (!robot.learned_body.empty()) {
        const std::string to = fmt::format("models/{}.body", robot.id);
        files.push_back({resolved_path(site, robot.learned_body), to});
        robot.learned_body = to;
        edit.values.push_back({"model", to});
    } else if (!robot.model.empty()) {
        robot.model.clear();
        robot.model_scale = 1;
        edit.values.insert(edit.values.end(), {{"parts", parts_text(robot.parts)}, {"model", ""}, {"model_scale", ""}});
    }
}

SiteEdit robot_edit(SiteRobot& robot, const Site& site, std::vector<CopiedFile>& files) {
    SiteEdit edit{robot.id, {}, "robots"};
    bool moved = false;
    const auto move = [&moved](std::string& source, const char* to) {
        if (source.empty()) return;
        source = to;
        moved = true;
    };
    for (Receiver& receiver : robot.receivers) move(receiver.source, "ranges.csv");
    if (robot.odometry) move(robot.odometry->source, "odometry.csv");
    if (robot.detector) move(robot.detector->source, "sightings.csv");
    if (moved) {
        for (const auto& [key, value] : senses_text(robot)) edit.values.push_back({key, value});
    }
    move_model(robot, site, edit, files);
    return edit;
}

/// The site file with its changes; where its way of writing does not allow them, the site written anew.
std::string changed_text(const std::string& text, const std::vector<SiteEdit>& edits, const Site& site) {
    auto changed = without_section(text, "outputs");
    if (changed) changed = without_section(*changed, "plan");
    for (const SiteEdit& edit : edits) {
        if (changed) changed = with_values(*changed, edit);
    }
    return changed ? *changed : site_text(site);
}

/// Does a text say where everything lies in the session, and of no output?
bool says(const std::string& text, const Site& site) {
    const LoadedSite read = parse_site(text, site.folder);
    const auto same_camera = [](const SiteCamera& a, const SiteCamera& b) {
        return a.id == b.id && a.source == b.source && a.background == b.background && a.lens_grid == b.lens_grid;
    };
    const auto same_robot = [](const SiteRobot& a, const SiteRobot& b) {
        return a.id == b.id && a.model == b.model && a.learned_body == b.learned_body && senses_text(a) == senses_text(b);
    };
    return std::equal(read.site.cameras.begin(), read.site.cameras.end(), site.cameras.begin(), site.cameras.end(), same_camera) &&
           std::equal(read.site.robots.begin(), read.site.robots.end(), site.robots.begin(), site.robots.end(), same_robot) &&
           outputs_text(read.site.outputs).empty() && !read.site.plan;
}

}  // namespace

Result<SessionContent> session_content(const SiteTracker& tracker, const fs::path& site_file, const std::vector<std::string>& background) {
    const auto text = read_text(site_file);
    if (!text) return text.error();
    SessionContent content;
    content.site = tracker.site();
    content.site.outputs = {};
    content.site.plan.reset();  // it is only looked at
    std::vector<SiteEdit> edits;
    for (SiteCamera& camera : content.site.cameras) edits.push_back(camera_edit(camera, tracker.site(), background, content.files));
    for (SiteRobot& robot : content.site.robots) edits.push_back(robot_edit(robot, tracker.site(), content.files));
    content.site_yaml = changed_text(*text, edits, content.site);
    if (!says(content.site_yaml, content.site)) content.site_yaml = site_text(content.site);
    for (std::size_t i = 0; i < tracker.cameras(); ++i) content.cameras.push_back(tracker.camera(i).id);
    return content;
}

}  // namespace roomfix
