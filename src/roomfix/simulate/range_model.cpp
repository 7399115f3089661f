#include "roomfix/simulate/range_model.hpp"

#include <fmt/format.h>

#include <cmath>

namespace roomfix {
namespace {

constexpr double listener_speed = 344.5;  // m/s: what the firmware takes for granted

}  // namespace

std::optional<HeardMessage> hear(const RangeModel& model, double distance, Random& random) {
    const bool lost = random.uniform() < model.lost;
    double measured = distance + random.normal(model.sigma);
    const double delay = -model.late_mean * std::log(random.uniform());
    if (random.uniform() < model.late_share) measured += delay;
    if (lost || measured <= 0) return std::nullopt;
    // Sound in air (Kim 2011, section 2); the radio's own flight is far below a microsecond.
    const double speed = 331.3 * std::sqrt(1 + (model.temperature + model.temperature_error) / 273.15);
    HeardMessage message;
    message.flight_time = std::round(measured / speed * 1e6) * 1e-6;
    message.distance = std::round(message.flight_time * listener_speed * 100) / 100;
    return message;
}

std::string cricket_line(const std::string& space, const HeardMessage& message, long clock_ms) {
    return fmt::format("VR=2.0,SP={},DB={},DR={},TM={},TS={}", space, std::lround(message.distance * 100), std::lround(message.flight_time * 1e6),
                       std::lround(message.flight_time * 1e6) + 360, clock_ms);
}

}  // namespace roomfix
