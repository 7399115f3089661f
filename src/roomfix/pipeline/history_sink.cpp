#include "roomfix/pipeline/history_sink.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "roomfix/base/steady_now.hpp"
#include "roomfix/connect/history_answer.hpp"

namespace roomfix {
namespace {

constexpr std::size_t most_at_once = 1000;  // fixes in one of them
constexpr double longest_wait = 3;          // intervals, until a database that failed again and again is tried once more
constexpr double removal_interval = 60;     // s

/// How many there were too many of.
template <class Numbered>
std::int64_t drop_oldest(std::deque<Numbered>& waiting, std::size_t most) {
    if (waiting.size() <= most) return 0;
    const auto lost = static_cast<std::ptrdiff_t>(waiting.size() - most);
    waiting.erase(waiting.begin(), waiting.begin() + lost);
    return lost;
}

}  // namespace

HistorySink::HistorySink(std::unique_ptr<FixStore> store, const HistorySettings& settings)
    : settings_(settings), store_(std::move(store)), thread_([this] { work(); }) {}

HistorySink::~HistorySink() { (void)finish(); }

Result<void> HistorySink::give(const FixBatch& batch) {
    {
        const std::lock_guard lock(mutex_);
        for (const Fix& fix : batch.given) {
            NumberedFix& numbered = waiting_.emplace_back(NumberedFix{next_number_++, fix});
            numbered.fix.hypotheses.clear();  // that is not stored
            numbered.fix.nis.clear();
        }
        for (const ZoneEvent& event : batch.zone_events) waiting_events_.push_back({next_event_++, event});
        state_.fixes.lost += drop_oldest(waiting_, settings_.most_waiting);
        state_.zone_events.lost += drop_oldest(waiting_events_, settings_.most_waiting);
        if (waiting_.size() < most_at_once) return {};
    }
    changed_.notify_all();
    return {};
}

void HistorySink::work() {
    double due = steady_now() + settings_.interval;
    std::unique_lock lock(mutex_);
    while (true) {
        // While the database is gone nothing but the end is worth waking up for.
        const double until = std::max(due, retry_at_);
        changed_.wait_for(lock, std::chrono::duration<double>(std::max(until - steady_now(), 0.0)),
                          [&] { return ending_ || (wait_ == 0 && waiting_.size() >= most_at_once); });
        const bool last = ending_;
        const bool nothing = waiting_.empty() && storing_.empty() && waiting_events_.empty() && storing_events_.empty();
        if (last && nothing) return;
        lock.unlock();
        const auto stored = store_some();
        if (!nothing) note(stored);
        if (stored) remove_old();
        due = steady_now() + settings_.interval;
        lock.lock();
        if (last && !stored) return;
    }
}

/// The next fixes, or those again that could not be stored.
Result<void> HistorySink::store_some() {
    if (storing_.empty() && storing_events_.empty()) {
        const std::lock_guard lock(mutex_);
        const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(std::min(waiting_.size(), most_at_once));
        std::move(waiting_.begin(), end, std::back_inserter(storing_));
        waiting_.erase(waiting_.begin(), end);
        storing_events_.assign(waiting_events_.begin(), waiting_events_.end());
        waiting_events_.clear();
    }
    if (storing_.empty() && storing_events_.empty()) return {};
    auto stored = store_->add(storing_, storing_events_);
    if (!stored) {
        wait_ = std::clamp(2 * wait_, settings_.interval, longest_wait * settings_.interval);
        retry_at_ = steady_now() + wait_;
        return stored;
    }
    wait_ = retry_at_ = 0;
    for (const NumberedFix& numbered : storing_) newest_ = std::max(newest_, numbered.fix.time);
    const std::lock_guard lock(mutex_);
    state_.fixes.stored += static_cast<std::int64_t>(storing_.size());
    state_.zone_events.stored += static_cast<std::int64_t>(storing_events_.size());
    storing_.clear();
    storing_events_.clear();
    return {};
}

/// By the fixes' own times, so that recordings of long ago can be stored, too; a time in the future deletes nothing.
void HistorySink::remove_old() {
    const double now = steady_now();
    if (newest_ == 0 || now < removed_at_ + removal_interval) return;
    removed_at_ = now;
    note(store_->remove_before(std::min(newest_, system_now()) - from_seconds(86400 * settings_.days)));
}

void HistorySink::note(const Result<void>& result) {
    std::string told;
    {
        const std::lock_guard lock(mutex_);
        if (!result && state_.ok) told = "not stored: " + result.error().message;
        if (result && !state_.ok)
            told = fmt::format("the history is stored again; {} fixes and {} events of zones are lost", state_.fixes.lost, state_.zone_events.lost);
        state_.ok = static_cast<bool>(result);
        state_.message = result ? "" : result.error().message;
    }
    if (!told.empty() && settings_.on_trouble) settings_.on_trouble(told);
}

SinkState HistorySink::state() const {
    const HistoryState now = stored();
    return {name(), now.ok ? "ok" : "failed", now.message, now.fixes.lost};
}

HistoryState HistorySink::stored() const {
    const std::lock_guard lock(mutex_);
    HistoryState state = state_;
    state.fixes.waiting = next_number_ - state.fixes.stored - state.fixes.lost;
    state.zone_events.waiting = next_event_ - state.zone_events.stored - state.zone_events.lost;
    return state;
}

Result<void> HistorySink::finish() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
    const HistoryState end = stored();
    if (end.fixes.missing() + end.zone_events.missing() == 0) return {};
    return Error{fmt::format("{} fixes and {} events of zones are missing in the history{}", end.fixes.missing(), end.zone_events.missing(),
                             end.ok ? "" : ": " + end.message)};
}

Result<std::unique_ptr<HistorySink>> open_history(const Site& site, const std::function<void(const std::string&)>& on_trouble) {
    const HistoryOutput& output = *site.outputs.history;
    auto store = FixStore::open(resolved_path(site, output.database), site.name, system_now());
    if (!store) return store.error();
    return std::make_unique<HistorySink>(std::move(*store), HistorySettings{.days = output.days, .on_trouble = on_trouble});
}

Result<HistoryAnswerers> history_answerers(const Site& site) {
    auto store = FixStore::open(resolved_path(site, site.outputs.history->database), site.name);
    if (!store) return store.error();
    struct Shared {
        std::mutex mutex;  // guards:
        std::unique_ptr<FixStore> store;
    };
    const auto shared = std::make_shared<Shared>();
    shared->store = std::move(*store);
    const auto answerer = [&](WebAnswer (*answer)(FixStore&, const WebParameters&)) -> WebAnswerer {
        return [shared, answer](const WebQuestion& question) {
            const std::lock_guard lock(shared->mutex);
            return answer(*shared->store, question.parameters);
        };
    };
    return HistoryAnswerers{answerer(answer_history), answerer(answer_zone_history)};
}

}  // namespace roomfix
