#include "roomfix/connect/sensed_lines.hpp"

#include <fmt/format.h>

#include "roomfix/base/number.hpp"
#include "roomfix/base/text_file.hpp"

namespace roomfix {
namespace {

const SiteRobot& robot_of(const Site& site, int robot) { return site.robots[static_cast<std::size_t>(robot)]; }
const std::string& beacon_id(const Site& site, int beacon) { return site.beacons[static_cast<std::size_t>(beacon)].id; }

std::string receiver_id(const Site& site, int robot, int receiver) {
    const auto& receivers = robot_of(site, robot).receivers;
    const auto index = static_cast<std::size_t>(receiver);
    return index < receivers.size() ? receivers[index].id : "";
}

std::string number_or_nothing(const std::optional<double>& value) { return value ? number_text(*value) : ""; }

}  // namespace

std::string sensed_line(const RangeObservation& range, const Site& site) {
    return fmt::format("{},{},{},{},{},{}\n", seconds_text(range.time), robot_of(site, range.robot).id, beacon_id(site, range.beacon), number_text(range.range),
                       number_text(range.sigma), receiver_id(site, range.robot, range.receiver));
}

std::string sensed_line(const RangeDifferenceObservation& difference, const Site& site) {
    return fmt::format("{},{},{},{},{},{},{}\n", seconds_text(difference.time), robot_of(site, difference.robot).id, beacon_id(site, difference.beacons[0]),
                       beacon_id(site, difference.beacons[1]), number_text(difference.difference), number_text(difference.sigma),
                       receiver_id(site, difference.robot, difference.receiver));
}

std::string sensed_line(const OdometryObservation& pose, const Site& site) {
    return fmt::format("{},{},{},{},{}\n", seconds_text(pose.time), robot_of(site, pose.robot).id, number_text(pose.pose.x), number_text(pose.pose.y),
                       number_text(pose.pose.yaw));
}

std::string sensed_line(const SightingObservation& sighting, const Site& site) {
    const std::string landmark = sighting.landmark < 0 ? "" : site.landmarks[static_cast<std::size_t>(sighting.landmark)].id;
    return fmt::format("{},{},{},{},{},{},{}\n", seconds_text(sighting.time), robot_of(site, sighting.robot).id, landmark, number_or_nothing(sighting.range),
                       number_or_nothing(sighting.bearing), number_text(sighting.range_sigma), number_text(sighting.bearing_sigma));
}

Result<SensedText> read_sensed(const std::filesystem::path& file) {
    auto text = read_text(file);
    if (!text) return text.error();
    std::error_code failure;
    const bool cut_off = !text->empty() && text->back() != '\n' && std::filesystem::exists(file.parent_path() / unfinished_mark, failure);
    if (!cut_off) return SensedText{std::move(*text), ""};
    text->resize(text->rfind('\n') + 1);  // npos + 1 is the beginning
    return SensedText{std::move(*text), "the last line is only a part of one, since the recording was cut off: it is left out"};
}

}  // namespace roomfix
