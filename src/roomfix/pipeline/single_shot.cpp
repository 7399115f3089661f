#include "roomfix/pipeline/single_shot.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <variant>

#include "roomfix/base/number.hpp"
#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/overlay.hpp"
#include "roomfix/connect/range_source.hpp"
#include "roomfix/pipeline/background_source.hpp"
#include "roomfix/pipeline/camera/camera_kind.hpp"
#include "roomfix/pipeline/published_method.hpp"

namespace roomfix {
namespace {

constexpr std::size_t enough_to_learn = 10;  // images that are their own background

std::optional<Nanoseconds> time_in_name(const std::string& image) { return parse_integer(std::filesystem::path(image).stem().string()); }

/// The newest range to each beacon around a picture's time; of pictures without a time, the newest of all.
std::vector<RangeObservation> ranges_around(const std::vector<RangeObservation>& ranges, std::optional<Nanoseconds> time) {
    constexpr double age = 0.5;  // s
    std::map<int, RangeObservation> newest;
    for (const RangeObservation& range : ranges) {
        if (!time || std::abs(to_seconds(range.time - *time)) < age) newest[range.beacon] = range;
    }
    std::vector<RangeObservation> around;
    for (const auto& [beacon, range] : newest) around.push_back(range);
    return around;
}

Result<std::vector<LumaImage>> load_frames(const std::vector<std::string>& sources) {
    std::vector<LumaImage> frames;
    for (const std::string& name : sources) {
        auto source = open_source(name);
        if (!source) return source.error();
        SourceFrame frame;
        while (frames.size() < 150) {
            const auto more = (*source)->next(frame);
            if (!more) return more.error();
            if (!*more) break;
            frames.push_back(std::move(frame.image));
        }
    }
    return frames;
}

/// Index of the site's thing that is called so.
template <class Things>
Result<int> named(const Things& things, const std::string& id, const char* option, const char* kind) {
    for (std::size_t i = 0; i < things.size(); ++i) {
        if (things[i].id == id) return static_cast<int>(i);
    }
    return Error{fmt::format("{} {}: the site has no such {}", option, id, kind)};
}

/// An error where an option does not go with the camera.
Result<void> check_options(const Site& site, const SiteCamera& camera, const ShotOptions& options) {
    const bool fixed = !std::holds_alternative<Mount>(camera.placement) && !std::holds_alternative<KnownHeight>(camera.placement);
    if (fixed && (!options.corner.empty() || options.heading)) {
        return Error{fmt::format("--corner and --heading-deg go with a camera that has 'height' or 'mount'; {} is fixed in the map", camera.id)};
    }
    if (fixed && (!options.ranges.empty() || !options.landmark.empty())) {
        return Error{fmt::format("--ranges and --landmark go with a camera on a robot; {} is fixed in the map", camera.id)};
    }
    if (!options.landmark.empty() && (looks_for_corners(site, camera) || !options.corner.empty())) {
        return Error{fmt::format("--landmark does not go with camera {}, which looks for corners", camera.id)};
    }
    if (site.robots.empty() && !std::holds_alternative<KnownHeight>(camera.placement)) {
        return Error{"the site has no robot: add one under 'robots' with its shape and size"};
    }
    return {};
}

/// A camera that looks at one picture after the other, with what the options say about them.
class SingleShot {
public:
    SingleShot(const Site& site, const SiteCamera& camera, CameraKind kind) : site_(site), camera_(camera), kind_(std::move(kind)) {}

    Result<void> use(const ShotOptions& options) {
        if (!options.corner.empty()) {
            const auto corner = named(site_.corners, options.corner, "--corner", "corner");
            if (!corner) return corner.error();
            hints_.corner = *corner;
        }
        if (!options.landmark.empty()) {
            const auto landmark = named(site_.landmarks, options.landmark, "--landmark", "landmark");
            if (!landmark) return landmark.error();
            hints_.landmark = *landmark;
        }
        hints_.heading = options.heading;
        note_ = options.note;
        if (auto used = use_ranges(options); !used) return used.error();
        std::vector<std::string> empty;
        if (auto* fixed = std::get_if<FixedCamera>(&kind_)) {
            if (auto used = use_background(*fixed, options, empty); !used) return used.error();
        }
        return options.published ? use_published(empty) : Result<void>();
    }

    std::vector<Fix> fixes(const std::string& image, const PictureView& frame) {
        const auto time = time_in_name(image);
        hints_.ranges = ranges_around(ranges_, time);
        std::vector<std::string> sources = {camera_.id};
        if (!hints_.ranges.empty()) sources.emplace_back("ranges");
        std::vector<Fix> fixes = fixes_of(look(frame), site_, time.value_or(0), sources);
        const auto* fixed = std::get_if<FixedCamera>(&kind_);
        if (fixed && fixed->moved()) note_(fmt::format("{}: camera {}: {}", image, camera_.id, fixed->how_moved()));
        for (Fix& fix : fixes) fix.image = image;
        return fixes;
    }

    Result<void> overlay(const std::filesystem::path& file, LumaView frame) const {
        const LumaView picture = picture_of(kind_, frame);
        Drawing drawing = drawing_of(kind_);
        add_lamps(drawing, picture);
        return save_overlay(file, picture, drawing);
    }

private:
    Result<void> use_ranges(const ShotOptions& options) {
        if (options.ranges.empty()) return {};
        if (robot_of(kind_) < 0) return Error{fmt::format("--ranges: camera {} is on no robot: ranges are heard by a robot's receiver", camera_.id)};
        auto batch = load_ranges(options.ranges, site_, robot_of(kind_));
        if (!batch) return batch.error();
        for (const std::string& problem : batch->problems) options.note(problem);
        ranges_ = std::move(batch->ranges);
        std::erase_if(ranges_, [&](const RangeObservation& r) { return r.robot != robot_of(kind_); });
        return {};
    }

    /// `sources`: where the background came from.
    Result<void> use_background(FixedCamera& fixed, const ShotOptions& options, std::vector<std::string>& sources) const {
        sources = background_sources(site_, camera_, options.background);
        if (sources.empty() && options.images.size() >= enough_to_learn) sources = options.images;
        if (sources.empty()) {
            return Error{
                fmt::format("camera {} has no background to compare with: give pictures without robots by --background, or 'background' in the site "
                            "file (or {} pictures or more at once)",
                            camera_.id, enough_to_learn)};
        }
        auto background = learn_background(camera_, sources);
        if (!background) return background.error();
        fixed.set_background(std::move(background->grey), std::move(background->colour));
        return {};
    }

    /// `empty`: sources of frames without robots, of a fixed camera.
    Result<void> use_published(const std::vector<std::string>& empty) {
        if (auto* fixed = std::get_if<FixedCamera>(&kind_)) {
            const auto frames = load_frames(empty);
            if (!frames) return frames.error();
            auto method = PublishedFixed::create(fixed->view(), *frames);
            if (!method) return method.error();
            published_.emplace<PublishedFixed>(std::move(*method));
        } else if (std::holds_alternative<LandmarkCamera>(kind_)) {
            auto method = PublishedOnboard::create(site_, camera_, robot_of(kind_), hints_);
            if (!method) return method.error();
            published_.emplace<PublishedOnboard>(std::move(*method));
        } else {
            published_.emplace<PublishedCorner>(camera_.model);
        }
        return {};
    }

    Sighting look(const PictureView& frame) {
        if (auto* by_blob = std::get_if<PublishedFixed>(&published_)) return by_blob->look(frame.grey);
        if (auto* by_corner = std::get_if<PublishedCorner>(&published_)) {
            auto& corners = std::get<CornerCamera>(kind_);
            corners.place(by_corner->look(frame.grey), hints_);
            return corners.sighting();
        }
        roomfix::look(kind_, frame, hints_);
        if (auto* by_leds = std::get_if<PublishedOnboard>(&published_)) return by_leds->look(frame.grey, hints_);
        return sighting_of(kind_);
    }

    Site site_;
    SiteCamera camera_;
    CameraKind kind_;
    FrameHints hints_;
    std::function<void(const std::string&)> note_;
    std::vector<RangeObservation> ranges_;
    std::variant<std::monostate, PublishedFixed, PublishedOnboard, PublishedCorner> published_;
};

/// A corner that is named is looked for, whatever else the camera could see; the published method of a camera of known height wants one.
Result<CameraKind> make_camera_for(const Site& site, const SiteCamera& camera, const ShotOptions& options) {
    const bool of_height = std::holds_alternative<KnownHeight>(camera.placement);
    if (options.corner.empty() && !(of_height && options.published)) return make_camera(site, camera);
    auto corners = CornerCamera::create(site, camera);
    if (!corners) return corners.error();
    return CameraKind(std::move(*corners));
}

}  // namespace

Fix empty_fix(const std::string& image, const std::string& reason) {
    Fix fix;
    fix.time = time_in_name(image).value_or(0);
    fix.image = image;
    fix.reason = reason;
    return fix;
}

Result<Shot> prepare_shot(const Site& site, const SiteCamera& camera, const ShotOptions& options) {
    if (auto fits = check_options(site, camera, options); !fits) return fits.error();
    auto kind = make_camera_for(site, camera, options);
    if (!kind) return kind.error();
    const auto single = std::make_shared<SingleShot>(site, camera, std::move(*kind));
    if (auto used = single->use(options); !used) return used.error();
    Shot shot;
    shot.model = camera.model;
    shot.fixes = [single](const std::string& image, const PictureView& frame) { return single->fixes(image, frame); };
    shot.overlay = [single](const std::filesystem::path& file, LumaView frame) { return single->overlay(file, frame); };
    return shot;
}

}  // namespace roomfix
