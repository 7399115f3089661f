#include "roomfix/pipeline/site_watch.hpp"

#include <chrono>
#include <fstream>
#include <sstream>

#include "roomfix/site/edit_site.hpp"
#include "roomfix/site/load_site.hpp"

namespace roomfix {
namespace {

constexpr auto interval = std::chrono::milliseconds(100);
constexpr int intervals_between_looks = 5;

std::string content_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

/// All of a site file but its zones.
std::string without_zones(const std::string& text) {
    const auto without = without_section(text, "zones");
    std::string rest = without ? *without : text;
    while (rest.ends_with('\n')) rest.pop_back();
    return rest;
}

}  // namespace

SiteWatch::SiteWatch(std::filesystem::path file, const std::atomic<bool>& stop, std::function<void(const std::string&)> refused)
    : file_(std::move(file)), thread_([this, &stop, refused = std::move(refused)] { watch(stop, refused); }) {}

SiteWatch::~SiteWatch() {
    leaving_ = true;
    thread_.join();
}

void SiteWatch::on_zones(std::function<void(const std::vector<SiteZone>&)> listener) {
    const std::lock_guard lock(listener_mutex_);
    listener_ = std::move(listener);
}

std::optional<std::vector<SiteZone>> SiteWatch::zones() const {
    const std::lock_guard lock(listener_mutex_);
    return zones_;
}

bool SiteWatch::tell_zones(const std::vector<SiteZone>& zones) {
    const std::lock_guard lock(listener_mutex_);
    if (!listener_) return false;
    zones_ = zones;
    listener_(zones);
    return true;
}

void SiteWatch::watch(const std::atomic<bool>& stop, const std::function<void(const std::string&)>& refused) {
    std::string used = content_of(file_);
    std::string seen = used;     // at the last look
    std::string refusal = used;  // the content that was refused last
    for (int i = 0; !leaving_ && !ends_; ++i) {
        std::this_thread::sleep_for(interval);
        if (stop) ends_ = true;
        if (i % intervals_between_looks != 0) continue;
        const std::string content = content_of(file_);
        const bool settled = content == seen;  // nobody is just writing it
        seen = content;
        if (!settled || content == used || content == refusal || content.empty()) continue;
        if (auto site = load_site(file_)) {
            if (without_zones(content) == without_zones(used) && tell_zones(site->zones)) {
                used = refusal = content;
                continue;
            }
            site_ = std::move(*site);
            changed_ = true;
            ends_ = true;
        } else {
            refusal = content;
            refused(site.error().message);
        }
    }
}

}  // namespace roomfix
