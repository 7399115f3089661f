// Fixes into the history, through everything that can happen to a database.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "roomfix/connect/fix_store.hpp"
#include "roomfix/connect/web_answer.hpp"
#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct HistorySettings {
    double days = 30;                                    // fixes older than this, by the newest one's time, are deleted
    double interval = 1;                                 // s between transactions
    std::size_t most_waiting = 50000;                    // fixes, and events of zones, that wait for a database that is gone; beyond that the oldest are lost
    std::function<void(const std::string&)> on_trouble;  // a sentence when the database vanishes or comes back; from the sink's thread
};

struct HistoryState {
    bool ok = true;
    std::string message;  // what is wrong now
    struct Count {
        std::int64_t stored = 0;
        std::int64_t waiting = 0;
        std::int64_t lost = 0;

        std::int64_t missing() const { return waiting + lost; }
    };
    Count fixes, zone_events;
};

/// Stores about once a second, each time all or nothing. A database that vanishes is tried again until it is back, and gets what it missed.
class HistorySink final : public FixSink {
public:
    HistorySink(std::unique_ptr<FixStore> store, const HistorySettings& settings);
    ~HistorySink() override;
    HistorySink(const HistorySink&) = delete;
    HistorySink& operator=(const HistorySink&) = delete;

    std::string name() const override { return "the history"; }
    Result<void> give(const FixBatch& batch) override;
    /// Tries for the last time. An error where fixes are lost.
    Result<void> finish() override;
    HistoryState stored() const;
    SinkState state() const override;

private:
    void work();
    Result<void> store_some();
    void remove_old();
    void note(const Result<void>& result);

    HistorySettings settings_;
    std::unique_ptr<FixStore> store_;   // used by the thread
    std::vector<NumberedFix> storing_;  // by the thread: what is tried until it is stored
    std::vector<NumberedZoneEvent> storing_events_;
    Nanoseconds newest_ = 0;    // of what was stored
    double removed_at_ = -1e9;  // s of the clock
    double retry_at_ = 0;       // s of the clock
    double wait_ = 0;           // s between attempts

    mutable std::mutex mutex_;  // guards:
    std::condition_variable changed_;
    std::deque<NumberedFix> waiting_;
    std::int64_t next_number_ = 0;
    std::deque<NumberedZoneEvent> waiting_events_;
    std::int64_t next_event_ = 0;
    HistoryState state_;
    bool ending_ = false;
    std::thread thread_;
};

/// The history that the site asks for, as a sink. An error if the program cannot use such a database at all; one that is gone for now is none.
Result<std::unique_ptr<HistorySink>> open_history(const Site& site, const std::function<void(const std::string&)>& on_trouble);
/// Answers of the same history for the page, one question after the other; over a connection of their own.
struct HistoryAnswerers {
    WebAnswerer fixes, zone_events;
};
Result<HistoryAnswerers> history_answerers(const Site& site);

}  // namespace roomfix
