// Notices that a site file was written anew while it is in use.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "roomfix/site/site.hpp"

namespace roomfix {

/// Looks at the file twice a second, in a thread of its own.
class SiteWatch {
public:
    /// `stop`: a wish to end altogether. `refused` gets the mistakes of a new file that cannot be used, from the watch's thread: the old one stays.
    SiteWatch(std::filesystem::path file, const std::atomic<bool>& stop, std::function<void(const std::string& mistakes)> refused);
    ~SiteWatch();
    SiteWatch(const SiteWatch&) = delete;
    SiteWatch& operator=(const SiteWatch&) = delete;

    /// Where nothing but the zones changed, `listener` gets them, from the watch's thread, and there is no new file. Without a listener that is a change like
    /// any other. An empty function: no longer; a call that goes on is waited for.
    void on_zones(std::function<void(const std::vector<SiteZone>&)> listener);
    /// Those that a listener got last, if any did.
    std::optional<std::vector<SiteZone>> zones() const;

    /// Set once there is a new file that can be used, or `stop` is set.
    const std::atomic<bool>& ends() const { return ends_; }
    /// Is there a new file?
    bool changed() const { return changed_; }
    /// What is in it, once `changed`.
    const Site& site() const { return site_; }

private:
    void watch(const std::atomic<bool>& stop, const std::function<void(const std::string&)>& refused);
    bool tell_zones(const std::vector<SiteZone>& zones);

    std::filesystem::path file_;
    Site site_;                          // set before `changed_`
    mutable std::mutex listener_mutex_;  // guards, and is held while the listener is called:
    std::function<void(const std::vector<SiteZone>&)> listener_;
    std::optional<std::vector<SiteZone>> zones_;
    std::atomic<bool> leaving_{false}, changed_{false}, ends_{false};
    std::thread thread_;
};

}  // namespace roomfix
