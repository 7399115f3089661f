#include "roomfix/ranging/flight_time.hpp"

#include <cmath>

namespace roomfix {
namespace {

constexpr double zero_celsius = 273.15;     // K
constexpr double speed_of_light = 2.998e8;  // m/s in air

}  // namespace

double speed_of_sound(double temperature) { return 331.3 * std::sqrt(1 + temperature / zero_celsius); }

double range_from_delay(double delay, double temperature) {
    const double c = speed_of_sound(temperature);
    return delay * c / (1 - c / speed_of_light);
}

double temperature_sigma(double range, double temperature, double sigma) { return range * sigma / (2 * (temperature + zero_celsius)); }

}  // namespace roomfix
