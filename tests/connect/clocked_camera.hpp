// A camera whose pictures show when they were taken.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "peer.hpp"
#include "roomfix/base/time.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

constexpr int clocked_width = 640, clocked_height = 480;

/// The time stands in the top rows: 32 bits of microseconds, black and white, and the same inverted below.
struct TimeCode {
    static constexpr int bits = 32, cell = clocked_width / bits, rows = 16;

    static void draw(Nanoseconds time, std::uint8_t* luma) {
        const auto code = static_cast<std::uint32_t>(time / 1000);
        for (int y = 0; y < 2 * rows; ++y) {
            for (int b = 0; b < bits; ++b) {
                const bool white = ((code >> b) & 1U) != (y >= rows ? 1U : 0U);
                std::memset(luma + y * clocked_width + b * cell, white ? 235 : 16, cell);
            }
        }
    }
    /// The time near another one; nothing where the picture shows none.
    static std::optional<Nanoseconds> read(LumaView picture, Nanoseconds near) {
        if (picture.width != clocked_width || picture.height != clocked_height) return std::nullopt;
        std::uint32_t code = 0;
        for (int b = 0; b < bits; ++b) {
            const bool white = picture.at(b * cell + cell / 2, rows / 2) > 128;
            if (white == (picture.at(b * cell + cell / 2, rows + rows / 2) > 128)) return std::nullopt;
            code |= static_cast<std::uint32_t>(white) << b;
        }
        const auto later = static_cast<std::int32_t>(code - static_cast<std::uint32_t>(near / 1000));
        return (near / 1000 + later) * 1000;
    }
};

/// Takes 25 pictures per second and gives them to a program: I420, if wanted each after its time (8 bytes).
class ClockedCamera {
public:
    ClockedCamera(const Peer& peer, bool with_time) : thread_([this, &peer, with_time] { run(peer, with_time); }) {}
    ~ClockedCamera() {
        stop_ = true;
        thread_.join();
    }
    ClockedCamera(const ClockedCamera&) = delete;
    ClockedCamera& operator=(const ClockedCamera&) = delete;

private:
    void run(const Peer& peer, bool with_time) {
        constexpr std::size_t head = 8, pixels = std::size_t{clocked_width} * clocked_height;
        std::vector<std::uint8_t> picture(head + pixels * 3 / 2, 128);
        auto due = std::chrono::steady_clock::now();
        for (int n = 0; !stop_; ++n) {
            std::uint8_t* luma = picture.data() + head;
            for (int y = 0; y < clocked_height; ++y) {
                for (int x = 0; x < clocked_width; ++x) luma[y * clocked_width + x] = static_cast<std::uint8_t>(60 + ((x + 3 * n) / 16 + y / 16) % 8 * 16);
            }
            const Nanoseconds time = system_now();
            TimeCode::draw(time, luma);
            std::memcpy(picture.data(), &time, head);
            if (!peer.write(with_time ? picture : std::vector<std::uint8_t>(picture.begin() + head, picture.end()))) return;
            due = std::max(due + std::chrono::milliseconds(40), std::chrono::steady_clock::now());
            std::this_thread::sleep_until(due);
        }
    }
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}  // namespace roomfix
