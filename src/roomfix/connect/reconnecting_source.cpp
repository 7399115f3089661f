#include "roomfix/connect/reconnecting_source.hpp"

#include <algorithm>
#include <utility>

namespace roomfix {

ReconnectingSource::ReconnectingSource(SourceOpener open, ReconnectSettings settings) : open_(std::move(open)), settings_(settings) {}
ReconnectingSource::~ReconnectingSource() = default;

void ReconnectingSource::wait() {
    std::unique_lock lock(mutex_);
    stopped_.wait_for(lock, wait_, [this] { return stop_.load(); });
    wait_ = std::clamp(2 * wait_, settings_.first_wait, settings_.longest_wait);
}

Result<void> ReconnectingSource::connect() {
    wait();
    if (stop_) return Error{"stopped"};
    auto opened = open_(stop_);
    if (!opened) return opened.error();
    const std::lock_guard lock(mutex_);
    source_ = std::move(*opened);
    if (keeps_files_) source_->keep_files();
    if (stop_) source_->interrupt();
    return {};
}

Result<bool> ReconnectingSource::advance(SourceFrame& frame) {
    if (!source_) {
        if (auto connected = connect(); !connected) return stop_ ? Result<bool>(false) : connected.error();
    }
    auto more = source_->advance(frame);
    if (stop_) return false;
    if (more && *more) {
        wait_ = std::chrono::milliseconds(0);
        return true;
    }
    passed_over_ += source_->passed_over();
    {
        const std::lock_guard lock(mutex_);
        source_.reset();
    }
    wait_ = std::max(wait_, settings_.first_wait);
    return more ? Error{"the camera ended its stream"} : more.error();
}

void ReconnectingSource::keep_files() {
    keeps_files_ = true;
    if (source_) source_->keep_files();
}

Result<void> ReconnectingSource::decode(SourceFrame& frame) { return source_ ? source_->decode(frame) : Result<void>(Error{"the camera is not there"}); }

std::string ReconnectingSource::note() const { return source_ ? source_->note() : ""; }

std::int64_t ReconnectingSource::passed_over() const { return passed_over_ + (source_ ? source_->passed_over() : 0); }

void ReconnectingSource::interrupt() {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    if (source_) source_->interrupt();
    stopped_.notify_all();
}

}  // namespace roomfix
