#include "roomfix/pipeline/site_doctor.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "roomfix/base/steady_now.hpp"
#include "roomfix/connect/camera_probe.hpp"
#include "roomfix/connect/fix_store.hpp"
#include "roomfix/connect/mqtt_client.hpp"
#include "roomfix/connect/network_camera.hpp"
#include "roomfix/connect/plan_picture.hpp"
#include "roomfix/connect/range_source.hpp"
#include "roomfix/connect/udp_port.hpp"
#include "roomfix/connect/web_server.hpp"
#include "roomfix/pipeline/live_senses.hpp"
#include "roomfix/pipeline/mqtt_sink.hpp"
#include "roomfix/pipeline/ros2_senses.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;
using Kind = Finding::Kind;

constexpr double broker_patience = 3;              // s
constexpr double ros_patience = 3;                 // s
constexpr std::uintmax_t little_space = 1u << 30;  // bytes
constexpr int dark = 12, bright = 243;             // grey levels beyond which a whole picture shows nothing

class Doctor {
public:
    Doctor(const Site& site, const std::function<void(const Finding&)>& found) : site_(site), found_(found) {}
    void look_at_clock() const;
    void look_at_cameras() const;
    void look_at_senses() const;
    void look_at_servers() const;
    void look_at_broker() const;
    void look_at_history() const;
    void look_at_files() const;

private:
    void report(Kind kind, const std::string& what, const std::string& text) const { found_({kind, what, text}); }
    void look_at_camera(const SiteCamera& camera) const;
    void look_at_sense(const std::string& what, const std::string& source) const;
    void look_at_ros_topic(const std::string& what, const std::string& source) const;
    void look_at_secret(const std::string& what, const std::optional<Secret>& secret) const;
    void look_at_folder(const std::string& what, const fs::path& folder) const;

    const Site& site_;
    const std::function<void(const Finding&)>& found_;
};

/// Does this machine's clock follow another one?
void Doctor::look_at_clock() const {
    timex clock = {};
    const int state = adjtimex(&clock);
    if (state < 0) return report(Kind::note, "clock", "whether it follows another clock cannot be told here");
    if (state == TIME_ERROR || (clock.status & STA_UNSYNC) != 0) {
        return report(Kind::note, "clock",
                      "follows no other clock: times of cameras and robots that have clocks of their own may differ from it; install chrony");
    }
    report(Kind::fine, "clock", fmt::format("follows another clock, to {:.1f} ms by its own estimate", 1e-3 * static_cast<double>(clock.esterror)));
}

/// Of a recording its first picture.
Result<CameraProbe> look_through(const std::string& source) {
    if (is_video_device(source) || is_network_address(source)) return probe_camera(source);
    auto picture = first_picture(source);
    if (!picture) return picture.error();
    return CameraProbe{std::move(*picture), 0, "a recording"};
}

void Doctor::look_at_camera(const SiteCamera& camera) const {
    const std::string what = "camera " + camera.id;
    const auto probe = look_through(resolved_path(site_, camera.source));
    if (!probe) return report(Kind::problem, what, probe.error().message);
    const LumaView picture = probe->picture.image.view();
    if (picture.width != camera.model.width || picture.height != camera.model.height) {
        return report(Kind::problem, what,
                      fmt::format("gives pictures of {} x {}, but 'size' says {} x {}: set the camera to the size that its lens was measured with",
                                  picture.width, picture.height, camera.model.width, camera.model.height));
    }
    double sum = 0;
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) sum += picture.at(x, y);
    }
    const double level = sum / (static_cast<double>(picture.width) * picture.height);
    std::string said = fmt::format("{} x {}", picture.width, picture.height);
    if (probe->rate > 0) said += fmt::format(", {:.1f} pictures per second", probe->rate);
    if (!probe->note.empty()) said += "; " + probe->note;
    if (level < dark || level > bright) {
        return report(Kind::note, what, said + fmt::format("; the picture is {}: is a lid on it, or the exposure fixed?", level < dark ? "black" : "white"));
    }
    report(Kind::fine, what, said);
}

void Doctor::look_at_cameras() const {
    if (site_.cameras.empty()) report(Kind::note, "cameras", "there are none");
    for (const SiteCamera& camera : site_.cameras) look_at_camera(camera);
}

/// Whoever publishes it has a moment to be found.
void Doctor::look_at_ros_topic(const std::string& what, const std::string& source) const {
    const auto senses = Ros2Senses::open(site_);
    if (!senses) return report(Kind::problem, what, senses.error().message);
    std::string told;
    for (const double end = steady_now() + ros_patience; steady_now() < end;) {
        for (const Ros2Senses::Heard& heard : (*senses)->read(0.1)) {
            if (heard.source != source) continue;
            if (!heard.reports.poses.empty()) return report(Kind::fine, what, source + " reports: " + heard.told);
            told = heard.told;
        }
    }
    report(Kind::problem, what, source + ": " + told);
}

void Doctor::look_at_sense(const std::string& what, const std::string& source) const {
    if (is_ros_topic(source)) return look_at_ros_topic(what, source);
    if (is_serial_line(source)) {
        const auto line = SerialLine::open(source);
        if (!line) return report(Kind::problem, what, line.error().message);
    } else if (is_udp_address(source)) {
        const auto port = UdpPort::open(source);
        if (!port) return report(Kind::problem, what, port.error().message);
    } else if (std::error_code failure; !is_mqtt_topic(source) && !fs::exists(resolved_path(site_, source), failure)) {
        return report(Kind::problem, what, resolved_path(site_, source) + ": does not exist: check 'source' in the site file");
    }
    report(Kind::fine, what, source + " can be read");
}

void Doctor::look_at_senses() const {
    std::set<std::string> seen;
    const auto look = [&](const std::string& what, const std::string& source) {
        if (!source.empty() && seen.insert(source).second) look_at_sense(what, source);
    };
    for (const SiteRobot& robot : site_.robots) {
        for (const Receiver& receiver : robot.receivers) look(fmt::format("robot {}, receiver", robot.id), receiver.source);
        if (robot.odometry) look(fmt::format("robot {}, odometry", robot.id), robot.odometry->source);
        if (robot.detector) look(fmt::format("robot {}, detector", robot.id), robot.detector->source);
    }
}

/// A secret that everybody on this machine can read is none.
void Doctor::look_at_secret(const std::string& what, const std::optional<Secret>& secret) const {
    if (!secret || secret->file.empty()) return;
    const std::string file = resolved_path(site_, secret->file);
    struct stat about = {};
    if (::stat(file.c_str(), &about) == 0 && (about.st_mode & (S_IROTH | S_IWOTH)) != 0) {
        report(Kind::note, what, fmt::format("{} can be read by everybody on this machine: chmod o-rw it", file));
    }
}

void Doctor::look_at_servers() const {
    const std::pair<const char*, const std::optional<WebOutput>&> servers[] = {{"the page", site_.outputs.web}, {"Foxglove's server", site_.outputs.foxglove}};
    for (const auto& [name, output] : servers) {
        if (!output) continue;
        look_at_secret(name, output->token);
        look_at_secret(name, output->operator_token);
        WebServer server;
        const auto access = web_access(*output, site_, name);
        const auto started = access ? server.start(*access) : Result<void>(access.error());
        if (!started) {
            report(Kind::problem, name, started.error().message);
        } else {
            report(Kind::fine, name, fmt::format("can be served at {}:{}", output->host, server.port()));
        }
    }
}

void Doctor::look_at_broker() const {
    if (!site_.outputs.mqtt) return;
    const std::string what = fmt::format("MQTT at {}:{}", site_.outputs.mqtt->host, site_.outputs.mqtt->port);
    look_at_secret(what, site_.outputs.mqtt->password);
    auto connection = mqtt_connection(site_, *site_.outputs.mqtt);
    auto client = connection ? MqttClient::start(*connection) : Result<std::unique_ptr<MqttClient>>(connection.error());
    if (!client) return report(Kind::problem, what, client.error().message);
    if ((*client)->wait_until_connected(broker_patience)) return report(Kind::fine, what, "the broker takes the connection");
    const std::string problem = (*client)->state().problem;
    report(Kind::problem, what,
           problem.empty() ? fmt::format("no answer within {} s: is the broker running, and does a firewall let this machine through?", broker_patience)
                           : problem);
}

void Doctor::look_at_history() const {
    if (!site_.outputs.history) return;
    const std::string& named = site_.outputs.history->database;
    const bool server = is_database_server(named);
    const std::string database = server ? named : resolved_path(site_, named);
    auto store = FixStore::open(database, site_.name);
    FixQuery one;
    one.limit = 1;
    const auto found = store ? (*store)->find(one) : Result<std::vector<Fix>>(store.error());
    if (!found) return report(Kind::problem, "history", found.error().message);
    report(Kind::fine, "history", server ? "the database answers" : database + " can be used");
    if (!server) look_at_folder("history", fs::path(database).parent_path());
}

void Doctor::look_at_folder(const std::string& what, const fs::path& folder) const {
    std::error_code failure;
    if (!fs::is_directory(folder, failure)) return report(Kind::problem, what, folder.string() + ": this folder does not exist: make it");
    if (::access(folder.c_str(), W_OK) != 0)
        return report(Kind::problem, what, folder.string() + ": this folder cannot be written to: give it to the user that runs roomfix");
    const fs::space_info space = fs::space(folder, failure);
    if (!failure && space.available < little_space) {
        report(Kind::note, what, fmt::format("{}: {:.1f} GB are free: that may not last", folder.string(), 1e-9 * static_cast<double>(space.available)));
    }
}

void Doctor::look_at_files() const {
    if (site_.plan) {
        const auto plan = load_plan_picture(site_, *site_.plan);
        if (!plan) report(Kind::problem, "plan", plan.error().message);
    }
    const auto folder_of = [&](const std::string& file) { return fs::path(resolved_path(site_, file)).parent_path(); };
    if (!site_.outputs.jsonl.empty()) look_at_folder("fixes", folder_of(site_.outputs.jsonl));
    if (!site_.outputs.tum.empty()) look_at_folder("TUM files", folder_of(site_.outputs.tum));
}

}  // namespace

void examine(const Site& site, const std::function<void(const Finding&)>& found) {
    const Doctor doctor(site, found);
    doctor.look_at_clock();
    doctor.look_at_cameras();
    doctor.look_at_senses();
    doctor.look_at_servers();
    doctor.look_at_broker();
    doctor.look_at_history();
    doctor.look_at_files();
}

}  // namespace roomfix
