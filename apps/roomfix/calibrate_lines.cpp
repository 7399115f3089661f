#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "calibrate.hpp"
#include "commands.hpp"
#include "roomfix/calibrate/plumb_line.hpp"
#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/overlay.hpp"
#include "roomfix/site/site_text.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::vector<std::string> pictures;
    std::string site, camera, overlay;
    WriteOptions write;
};

/// The edges of all pictures.
struct Harvest {
    std::vector<LongEdge> edges;
    LumaImage first;
};

Result<Harvest> harvest(const std::vector<std::string>& pictures, const SiteCamera& camera) {
    Harvest all;
    const auto progress = progress_bar("following edges");
    std::size_t number = 0;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        auto source = open_source(pictures[i]);
        if (!source) return source.error();
        if ((*source)->live()) return Error{pictures[i] + ": take pictures first; a live camera has no end"};
        SourceFrame frame;
        for (;; ++number) {
            const auto more = (*source)->next(frame);
            if (!more) return more.error();
            if (!*more) break;
            if (frame.image.width() != camera.model.width || frame.image.height() != camera.model.height) {
                return Error{fmt::format("{} is {} x {} pixels, camera {} has {} x {}", frame.name, frame.image.width(), frame.image.height(), camera.id,
                                         camera.model.width, camera.model.height)};
            }
            for (LongEdge& edge : long_edges(frame.image, number)) all.edges.push_back(std::move(edge));
            if (number == 0) all.first = std::move(frame.image);
        }
        progress(static_cast<double>(i + 1) / static_cast<double>(pictures.size()));
    }
    return all;
}

Result<void> save_overlay(const std::string& file, const Harvest& all, const PlumbLine& found) {
    std::vector<std::vector<Eigen::Vector2d>> straight, others;
    for (const LongEdge& edge : found.edges) {
        if (edge.picture == 0) (edge.used ? straight : others).push_back(edge.points);
    }
    return save_edges_overlay(file, all.first, straight, others);
}

int calibrate_lines_command(const Arguments& arguments) {
    const auto place = load_camera(arguments.site, arguments.camera);
    if (!place) return give_up(place.error());
    const SiteCamera& camera = place->camera;
    const auto all = harvest(arguments.pictures, camera);
    if (!all) return give_up(all.error());
    const auto found = straighten(all->edges, camera.model);
    if (!found) return give_up(found.error());
    const IntrinsicsMatrix covariance = covariance_with_focal(*found, camera.intrinsics_covariance);
    const auto sigma = [&](int i) { return std::sqrt(covariance(i, i)); };
    fmt::print("{} of {} edges are straight: {:.2f} px rms off with the lens of the site file, {:.2f} px with the one that was found\n", found->used,
               found->edges.size(), found->before, found->rms);
    const CameraModel& m = found->model;
    fmt::print("  cx {:9.3f} +- {:.3f}\n  cy {:9.3f} +- {:.3f}\n", m.cx, sigma(2), m.cy, sigma(3));
    const char* const names[] = {"k1", "k2", "p1", "p2"};
    for (int i = 0; i < 4; ++i) fmt::print("  {} {:9.5f} +- {:.5f}\n", names[i], m.distortion[static_cast<std::size_t>(i)], sigma(4 + i));
    constexpr double crooked = 0.3;  // px
    if (found->rms > crooked) {
        fmt::print(
            "  edges are still {:.2f} px off straight lines: many of them are bent in truth, and the lens may be wrong by more than stated; choose pictures\n"
            "  with door frames and skirtings instead\n",
            found->rms);
    }
    fmt::print("  for fx {:.2f}, fy {:.2f}: straight lines do not tell the focal length\n", m.fx, m.fy);
    if (!arguments.overlay.empty()) {
        if (auto saved = save_overlay(arguments.overlay, *all, *found); !saved) return give_up(saved.error());
        say("overlay: " + arguments.overlay);
    }
    return write_or_show(arguments.site, camera.id,
                         {{"intrinsics", intrinsics_text(m, covariance)}, {"distortion_model", ""}, {"distortion", distortion_text(m)}, {"lens_grid", ""}},
                         lens_quality(camera, m, covariance), arguments.write);
}

}  // namespace

void add_calibrate_lines(Command& calibrate) {
    Command lines = calibrate.add_command("lines", "distortion without any board: edges of a room made straight");
    auto arguments = std::make_shared<Arguments>();
    lines.option("SITE", arguments->site, "site file").required();
    lines.option("PICTURES", arguments->pictures, "pictures, folders or videos that the camera took of rooms").required();
    lines.option("--camera", arguments->camera, "camera of the site file, with its focal length").required();
    lines.option("--overlay", arguments->overlay, "picture to write: the first one with its edges");
    add_write_options(lines, arguments->write);
    lines.footer("Example: roomfix calibrate lines site.yaml pictures/ --camera hall --overlay edges.png --write");
    lines.on_run([=] { return calibrate_lines_command(*arguments); });
}

}  // namespace roomfix
