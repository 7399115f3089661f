#include "roomfix/base/own_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fstream>

namespace roomfix {
namespace {

/// Bytes of address space that this process has now; 0 where the system does not say.
rlim_t address_space() {
    std::ifstream pages("/proc/self/statm");
    rlim_t count = 0;
    pages >> count;
    return pages ? count * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) : 0;
}

void limit(int seconds, int megabytes) {
    const auto set = [](__rlimit_resource resource, rlim_t most) {
        const rlimit value{most, most};
        setrlimit(resource, &value);
    };
    set(RLIMIT_CORE, 0);
    set(RLIMIT_CPU, static_cast<rlim_t>(seconds));
    set(RLIMIT_AS, address_space() + (static_cast<rlim_t>(megabytes) << 20U));
}

bool write_all(int pipe, const char* data, std::size_t size) {
    while (size > 0) {
        const ssize_t written = write(pipe, data, size);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        data += written;
        size -= static_cast<std::size_t>(written);
    }
    return true;
}

/// The copy: gives its text with the length before it, and ends without running anything that the original still has to.
[[noreturn]] void run_copy(int pipe, const std::function<std::string()>& work, int seconds, int megabytes) {
    for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU, SIGTERM, SIGINT}) signal(number, SIG_DFL);
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    limit(seconds, megabytes);
    try {
        const std::string text = work();
        const std::uint64_t size = text.size();
        std::array<char, sizeof size> head;
        std::memcpy(head.data(), &size, sizeof size);
        if (write_all(pipe, head.data(), head.size()) && write_all(pipe, text.data(), text.size())) _exit(0);
    } catch (...) {  // out of memory, or a library's own exception: the original is told "crashed"
    }
    _exit(1);
}

std::string read_all(int pipe) {
    std::string text;
    std::array<char, 65536> buffer;
    for (;;) {
        const ssize_t count = read(pipe, buffer.data(), buffer.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return text;
        text.append(buffer.data(), static_cast<std::size_t>(count));
    }
}

}  // namespace

Result<std::string> in_own_process(const std::function<std::string()>& work, int seconds, int megabytes) {
    std::array<int, 2> ends;
    if (pipe2(ends.data(), O_CLOEXEC) != 0) return Error{fmt::format("cannot be started: {}", std::strerror(errno))};
    const pid_t copy = fork();
    if (copy == 0) {
        close(ends[0]);
        run_copy(ends[1], work, seconds, megabytes);
    }
    close(ends[1]);
    if (copy < 0) {
        close(ends[0]);
        return Error{fmt::format("cannot be started: {}", std::strerror(errno))};
    }
    std::string text = read_all(ends[0]);
    close(ends[0]);
    int status = 0;
    while (waitpid(copy, &status, 0) < 0 && errno == EINTR) {
    }
    std::uint64_t size = 0;
    if (text.size() >= sizeof size) std::memcpy(&size, text.data(), sizeof size);
    if (text.size() >= sizeof size && text.size() - sizeof size == size) return text.substr(sizeof size);
    const bool slow = WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL);
    return Error{slow ? fmt::format("took more than {} s", seconds) : std::string("crashed")};
}

}  // namespace roomfix
