#include "roomfix/pipeline/session_parts.hpp"

#include <fmt/format.h>

namespace roomfix {
namespace {

constexpr double parts = 10;  // that the limits are made of

}  // namespace

Result<SessionWriter*> SessionParts::current(double now) {
    Result<void> result;
    if (writer_ && is_full(now)) result = end_part(now);
    if (!writer_) {
        if (auto begun = begin(now); !begun) return begun.error();
    }
    remove_oldest(now);
    if (!result) return result.error();
    return writer_.get();
}

bool SessionParts::is_full(double now) const {
    const bool old = limits_.minutes > 0 && now - begun_ >= 60 * limits_.minutes / parts;
    const bool large = limits_.gigabytes > 0 && static_cast<double>(writer_->bytes()) >= 1e9 * limits_.gigabytes / parts;
    return old || large;
}

Result<void> SessionParts::begin(double now) {
    const std::filesystem::path folder = limits_.any() ? folder_ / fmt::format("part-{:04}", number_ + 1) : folder_;
    auto created = SessionWriter::create(folder, content_, ended_.empty() ? std::filesystem::path() : ended_.back().folder);
    if (!created) return created.error();
    writer_ = std::move(*created);
    begun_ = now;
    ++number_;
    return {};
}

Result<void> SessionParts::end_part(double now) {
    auto finished = writer_->finish();
    ended_.push_back({writer_->folder(), writer_->bytes(), now});
    lost_lines_ += writer_->lost_lines() + writer_->waiting_lines();
    writer_.reset();
    return finished;
}

void SessionParts::remove_oldest(double now) {
    const auto beyond = [&] {
        if (limits_.minutes > 0 && now - ended_.front().end > 60 * limits_.minutes) return true;
        return limits_.gigabytes > 0 && static_cast<double>(bytes()) > 1e9 * limits_.gigabytes;
    };
    while (!ended_.empty() && beyond()) {
        std::error_code failure;
        std::filesystem::remove(ended_.front().folder / "site.yaml", failure);  // half of a session is none
        std::filesystem::remove_all(ended_.front().folder, failure);
        ended_.pop_front();
    }
}

Result<void> SessionParts::flush() { return writer_ ? writer_->flush() : Result<void>(); }

Result<void> SessionParts::finish() {
    if (!writer_) return {};
    auto finished = writer_->finish();
    lost_lines_ += writer_->waiting_lines();
    return finished;
}

std::int64_t SessionParts::bytes() const {
    std::int64_t sum = writer_ ? writer_->bytes() : 0;
    for (const Part& part : ended_) sum += part.bytes;
    return sum;
}

}  // namespace roomfix
