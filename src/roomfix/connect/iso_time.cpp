#include "roomfix/connect/iso_time.hpp"

#include <fmt/format.h>

#include <chrono>

namespace roomfix {

std::string iso_time(Nanoseconds time) {
    using namespace std::chrono;
    const auto since_epoch = floor<milliseconds>(nanoseconds(time));
    const auto day = floor<days>(since_epoch);
    const year_month_day date{sys_days(day)};
    const hh_mm_ss clock(since_epoch - day);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                       static_cast<unsigned>(date.day()), clock.hours().count(), clock.minutes().count(), clock.seconds().count(), clock.subseconds().count());
}

}  // namespace roomfix
