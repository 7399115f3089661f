// From flight times to metres.
#pragma once

namespace roomfix {

/// Speed of sound in air, m/s, at a temperature in degC: 331.3 sqrt(1 + T / 273.15). Source: Kim 2011, section 2; dry air.
double speed_of_sound(double temperature);

/// The distance (m) of a beacon that sent radio and sound at once, when the sound came `delay` seconds after the radio. The radio's
/// own flight is taken into account.
double range_from_delay(double delay, double temperature);

/// Standard deviation that an air temperature known to `sigma` degC adds to a range, m.
double temperature_sigma(double range, double temperature, double sigma);

}  // namespace roomfix
