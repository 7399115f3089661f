// A stretch of recent events in the order of their times, whatever the order of their arrival, and the state after the last of them.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "roomfix/base/time.hpp"

namespace roomfix {

enum class Taken { yes, late, twice };

/// `Event` has `time` and is ordered by `<`, without ties between different events. `step(state, event)` takes the state from one event
/// to the next; it must depend on nothing else that changes. States are copied now and then, so that a late event costs only the events
/// after it: the result is the same as if all had come in order.
template <class State, class Event>
class LagBuffer {
public:
    LagBuffer(const State& initial, Nanoseconds lag) : lag_(lag), state_(initial) { checkpoints_.push_back({0, initial}); }

    /// Takes an event; `late` where it is older than the lag before the newest one, `twice` where it is already there.
    template <class Step>
    Taken add(const Event& event, const Step& step) {
        if (!events_.empty() && event.time < events_.back().time - lag_) return Taken::late;
        const auto after = std::upper_bound(events_.begin() + first_, events_.end(), event);
        if (after != events_.begin() + first_ && !(*(after - 1) < event)) return Taken::twice;
        const auto place = after - events_.begin();
        if (after == events_.end()) {
            events_.push_back(event);
            run(step, place, place + 1);
        } else {
            events_.insert(after, event);
            redo_from_place(place, step);
        }
        trim();
        return Taken::yes;
    }

    /// Runs again all events later than `time`: what they rest on has changed.
    template <class Step>
    void redo_after(Nanoseconds time, const Step& step) {
        const auto from = std::upper_bound(events_.begin() + first_, events_.end(), time, [](Nanoseconds t, const Event& e) { return t < e.time; });
        if (from != events_.end()) redo_from_place(from - events_.begin(), step);
    }

    /// What is known of the past has changed: `change(state)` makes the state what it was after all events up to `time`; the later ones run again. Nothing
    /// happens where the buffer does not reach that far back.
    template <class Change, class Step>
    void restart(Nanoseconds time, const Change& change, const Step& step) {
        if (time < reach_) return;
        const auto end = std::upper_bound(events_.begin() + first_, events_.end(), time, [](Nanoseconds t, const Event& e) { return t < e.time; });
        State state = at(time, step);
        change(state);
        first_ = end - events_.begin();
        reach_ = time;
        checkpoints_.clear();
        checkpoints_.push_back({first_, state});
        state_ = state;
        run(step, first_, static_cast<Place>(events_.size()));
    }

    /// The state after the newest event.
    const State& newest() const { return state_; }
    bool empty() const { return events_.empty(); }
    Nanoseconds newest_time() const { return events_.back().time; }
    /// The time of the oldest state that is kept: nothing before it is needed any more.
    Nanoseconds reach() const { return reach_; }
    /// The state after the last event that is not later than `time`; as old as the buffer reaches, if need be.
    template <class Step>
    State at(Nanoseconds time, const Step& step) const {
        const auto end = std::upper_bound(events_.begin() + first_, events_.end(), time, [](Nanoseconds t, const Event& e) { return t < e.time; });
        if (end == events_.end()) return state_;
        const auto place = end - events_.begin();
        auto from = checkpoints_.end() - 1;
        while (from != checkpoints_.begin() && from->place > place) --from;
        State state = from->state;
        for (auto i = from->place; i < place; ++i) step(state, events_[static_cast<std::size_t>(i)]);
        return state;
    }

private:
    using Place = std::ptrdiff_t;
    struct Checkpoint {
        Place place;  // of the first event that is not in it
        State state;
    };
    static constexpr Place stride = 16;

    /// Where something changed, more will change soon: wheels are heard of a little after what was seen on the way. So that place becomes a checkpoint; of
    /// those between whole strides only the last is kept.
    template <class Step>
    void redo_from_place(Place place, const Step& step) {
        while (checkpoints_.size() > 1 && checkpoints_.back().place > place) checkpoints_.pop_back();
        state_ = checkpoints_.back().state;
        const Place from = checkpoints_.back().place;
        run(step, from, place);
        if (checkpoints_.back().place < place) {
            const auto last = checkpoints_.size() - 1;
            if (last > 0 && checkpoints_[last].place - checkpoints_[last - 1].place < stride) checkpoints_.pop_back();
            checkpoints_.push_back({place, state_});
        }
        run(step, place, static_cast<Place>(events_.size()));
    }

    template <class Step>
    void run(const Step& step, Place from, Place to) {
        for (Place i = from; i < to; ++i) {
            if (i - checkpoints_.back().place >= stride) checkpoints_.push_back({i, state_});
            step(state_, events_[static_cast<std::size_t>(i)]);
        }
    }

    /// Forgets events that nothing can come before any more.
    void trim() {
        const Nanoseconds horizon = events_.back().time - lag_;
        std::size_t base = 0;
        while (base + 1 < checkpoints_.size() && events_[static_cast<std::size_t>(checkpoints_[base + 1].place - 1)].time < horizon) ++base;
        if (base == 0) return;
        first_ = checkpoints_[base].place;
        reach_ = events_[static_cast<std::size_t>(first_ - 1)].time;
        checkpoints_.erase(checkpoints_.begin(), checkpoints_.begin() + static_cast<std::ptrdiff_t>(base));
        if (first_ < 256 && first_ < static_cast<Place>(events_.size()) / 2) return;
        events_.erase(events_.begin(), events_.begin() + first_);
        for (Checkpoint& checkpoint : checkpoints_) checkpoint.place -= first_;
        first_ = 0;
    }

    Nanoseconds lag_;
    Nanoseconds reach_ = std::numeric_limits<Nanoseconds>::min() / 2;
    std::vector<Event> events_;  // those before `first_` are only waiting to be removed
    Place first_ = 0;
    std::vector<Checkpoint> checkpoints_;  // in order; the first is the state before `first_`
    State state_;
};

}  // namespace roomfix
