// A PostgreSQL server of a test's own, in a folder of its own, without a port.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace roomfix {

class PostgresServer {
public:
    /// Where Debian puts the server's programs; empty: it is not installed.
    static std::filesystem::path programs() {
        std::error_code failure;
        for (const auto& version : std::filesystem::directory_iterator("/usr/lib/postgresql", failure)) {
            if (std::filesystem::exists(version.path() / "bin/postgres", failure)) return version.path() / "bin";
        }
        return {};
    }

    /// The server does not run as root.
    explicit PostgresServer(const std::filesystem::path& folder) : folder_(folder) {
        std::filesystem::create_directories(folder_);
        if (geteuid() == 0 && chown(folder_.c_str(), nobody, nobody) != 0) return;
        made_ = wait_for(spawn({programs() / "initdb", "-D", folder_ / "data", "-U", "roomfix", "-A", "trust", "-E", "UTF8", "--no-sync", "--no-locale"}));
    }
    ~PostgresServer() {
        stop();
        std::filesystem::remove_all(folder_);
    }
    PostgresServer(const PostgresServer&) = delete;
    PostgresServer& operator=(const PostgresServer&) = delete;

    bool made() const { return made_; }
    std::string address() const { return fmt::format("postgresql://roomfix@/postgres?host={}", folder_.string()); }

    /// Waits until it answers.
    bool start() {
        server_ = spawn({programs() / "postgres", "-D", folder_ / "data", "-k", folder_, "-c", "listen_addresses=", "-c", "fsync=off", "-c",
                         "shared_buffers=1MB", "-c", "max_connections=8"});
        for (int i = 0; i < 600; ++i) {
            if (wait_for(spawn({programs() / "pg_isready", "-q", "-h", folder_}))) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
        return false;
    }

    /// As if the machine lost its power: nobody is said good-bye.
    void stop() {
        if (server_ <= 0) return;
        ::kill(server_, SIGQUIT);
        (void)wait_for(server_);
        server_ = -1;
    }

private:
    static constexpr uid_t nobody = 65534;

    static pid_t spawn(const std::vector<std::string>& command) {
        std::vector<char*> arguments;
        for (const std::string& part : command) arguments.push_back(const_cast<char*>(part.c_str()));
        arguments.push_back(nullptr);
        const pid_t child = ::fork();
        if (child != 0) return child;
        const int silence = ::open("/dev/null", O_RDWR);
        for (int i = 0; i < 3; ++i) ::dup2(silence, i);
        if (geteuid() == 0 && (setgid(nobody) != 0 || setuid(nobody) != 0)) _exit(126);
        if (::chdir("/") == 0) ::execv(arguments[0], arguments.data());
        _exit(127);
    }

    static bool wait_for(pid_t child) {
        int status = 0;
        return child > 0 && ::waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
    }

    std::filesystem::path folder_;
    bool made_ = false;
    pid_t server_ = -1;
};

}  // namespace roomfix
