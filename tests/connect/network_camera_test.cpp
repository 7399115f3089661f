// Cameras on the network: real servers, pictures that show when they were taken.
#include "roomfix/connect/network_camera.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "clocked_camera.hpp"
#include "roomfix/connect/shown_address.hpp"

namespace roomfix {
namespace {

/// A server and the camera behind it.
struct ServedCamera {
    std::unique_ptr<Peer> server;
    std::unique_ptr<ClockedCamera> camera;

    ServedCamera() { ::signal(SIGPIPE, SIG_IGN); }
    ~ServedCamera() { end(); }
    ServedCamera(ServedCamera&&) = default;
    ServedCamera& operator=(ServedCamera&&) = delete;
    void end() {
        if (server) server->kill();
        camera.reset();
        server.reset();
    }
};

ServedCamera mjpeg_camera(int port) {
    ServedCamera served;
    const std::string size = fmt::format("{}x{}", clocked_width, clocked_height);
    served.server = std::make_unique<Peer>(std::vector<std::string>{"ffmpeg",
                                                                    "-loglevel",
                                                                    "quiet",
                                                                    "-fflags",
                                                                    "nobuffer",
                                                                    "-probesize",
                                                                    "32",
                                                                    "-analyzeduration",
                                                                    "0",
                                                                    "-f",
                                                                    "rawvideo",
                                                                    "-pix_fmt",
                                                                    "yuv420p",
                                                                    "-video_size",
                                                                    size,
                                                                    "-framerate",
                                                                    "25",
                                                                    "-i",
                                                                    "pipe:0",
                                                                    "-vsync",
                                                                    "passthrough",
                                                                    "-c:v",
                                                                    "mjpeg",
                                                                    "-threads",
                                                                    "1",
                                                                    "-q:v",
                                                                    "3",
                                                                    "-f",
                                                                    "mpjpeg",
                                                                    "-flush_packets",
                                                                    "1",
                                                                    "-content_type",
                                                                    "multipart/x-mixed-replace;boundary=ffmpeg",
                                                                    "-listen",
                                                                    "1",
                                                                    fmt::format("http://127.0.0.1:{}/camera", port)});
    served.camera = std::make_unique<ClockedCamera>(*served.server, false);
    return served;
}

ServedCamera rtsp_camera(int port, const std::string& coding) {
    ServedCamera served;
    served.server = std::make_unique<Peer>(std::vector<std::string>{"/usr/bin/python3", ROOMFIX_SOURCE "/tests/connect/rtsp_server.py", std::to_string(port),
                                                                    std::to_string(clocked_width), std::to_string(clocked_height), coding});
    if (!served.server->wait_for_line()) ADD_FAILURE() << "GStreamer's RTSP server does not start";
    served.camera = std::make_unique<ClockedCamera>(*served.server, true);
    return served;
}

struct Measured {
    std::vector<double> errors;  // s, of times against when the pictures were taken, by size
    double sigma = 0;            // s, as last stated
    long disordered = 0;         // pictures that were no later than the one before
    std::size_t encoded = 0;     // bytes of the last picture as it came
    std::string note;

    double quantile(double q) const { return errors.empty() ? 1e9 : errors[static_cast<std::size_t>(q * static_cast<double>(errors.size() - 1))]; }
    void print(const std::string& name) const {
        fmt::print("{}: {} pictures, time error median {:.1f} ms, 90 % {:.1f} ms, 99 % {:.1f} ms; {}\n", name, errors.size(), 1e3 * quantile(0.5),
                   1e3 * quantile(0.9), 1e3 * quantile(0.99), note);
    }
};

/// Looks at pictures until `enough` says so; gives up after 500 attempts.
Measured measure(FrameSource& source, const std::function<bool(const Measured&)>& enough) {
    Measured measured;
    SourceFrame frame;
    Nanoseconds last = 0;
    for (int attempt = 0; attempt < 500 && !enough(measured); ++attempt) {
        const auto more = source.next(frame);
        if (!more || !*more) continue;
        measured.note = source.note();
        measured.sigma = frame.time_error.sigma;
        measured.encoded = frame.encoded.size();
        measured.disordered += frame.time <= last;
        last = frame.time;
        if (const auto taken = TimeCode::read(frame.image, frame.time)) measured.errors.push_back(std::abs(to_seconds(frame.time - *taken)));
    }
    std::sort(measured.errors.begin(), measured.errors.end());
    return measured;
}

auto pictures(std::size_t count) {
    return [count](const Measured& m) { return m.errors.size() >= count; };
}

bool camera_tells_time(const std::string& note) { return note.find("the camera's own") != std::string::npos; }

/// Waits for the first sender report, and measures.
void expect_true_times(FrameSource& source, bool jpeg) {
    const Measured before = measure(source, [](const Measured& m) { return camera_tells_time(m.note); });
    EXPECT_TRUE(camera_tells_time(before.note)) << before.note;
    const Measured measured = measure(source, pictures(25));
    before.print(jpeg ? "RTSP, JPEG, before the first sender report" : "RTSP, H.264, before the first sender report");
    measured.print(jpeg ? "RTSP, JPEG" : "RTSP, H.264");
    EXPECT_LE(measured.quantile(0.5), 0.005);
    EXPECT_LE(measured.sigma, 0.005);
    EXPECT_EQ(measured.disordered, 0);
    EXPECT_EQ(measured.encoded > 0, jpeg);
}

TEST(NetworkCamera, SenderReportsGiveTheTimeOfEachPictureAndACameraThatStandsStillIsAway) {
    const int h264_port = free_port(), jpeg_port = free_port();
    const ServedCamera h264 = rtsp_camera(h264_port, "h264"), jpeg = rtsp_camera(jpeg_port, "jpeg");
    auto h264_source = open_lasting_source(fmt::format("rtsp://127.0.0.1:{}/camera", h264_port));
    auto jpeg_source = open_lasting_source(fmt::format("rtsp://127.0.0.1:{}/camera", jpeg_port));
    ASSERT_TRUE(h264_source && jpeg_source);
    std::thread other([&] { expect_true_times(**h264_source, false); });
    expect_true_times(**jpeg_source, true);
    other.join();
    jpeg.server->signal(SIGSTOP);
    SourceFrame frame;
    auto stopped = (*jpeg_source)->next(frame);
    while (stopped) stopped = (*jpeg_source)->next(frame);
    EXPECT_NE(stopped.error().message.find("no picture for 3 s"), std::string::npos) << stopped.error().message;
    jpeg.server->signal(SIGCONT);
    EXPECT_GE(measure(**jpeg_source, pictures(5)).errors.size(), 5U);
}

TEST(NetworkCamera, MjpegThatVanishesAndComesBackGoesOn) {
    const int port = free_port();
    auto source = open_lasting_source(fmt::format("http://127.0.0.1:{}/camera", port));
    ASSERT_TRUE(source);
    SourceFrame frame;
    const auto nobody = (*source)->advance(frame);
    ASSERT_FALSE(nobody);
    EXPECT_NE(nobody.error().message.find("Connection refused"), std::string::npos) << nobody.error().message;
    for (int life = 0; life < 2; ++life) {
        ServedCamera camera = mjpeg_camera(port);
        const Measured measured = measure(**source, pictures(20));
        measured.print("MJPEG");
        ASSERT_GE(measured.errors.size(), 20U);
        EXPECT_LT(measured.quantile(0.5), 2 * measured.sigma);
        EXPECT_EQ(measured.disordered, 0);
        EXPECT_GT(measured.encoded, 1000U);
        EXPECT_NE(measured.note.find("times are those of arrival"), std::string::npos) << measured.note;
        camera.end();
        auto gone = (*source)->next(frame);
        while (gone) gone = (*source)->next(frame);
        EXPECT_NE(gone.error().message.find("stream"), std::string::npos) << gone.error().message;
    }
}

TEST(NetworkCamera, WhoWaitsForACameraIsInterrupted) {
    // It takes connections and never answers.
    const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ASSERT_EQ(::bind(listener, reinterpret_cast<sockaddr*>(&address), size), 0);
    ASSERT_EQ(::listen(listener, 5), 0);
    ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
    auto source = open_lasting_source(fmt::format("rtsp://user:secret@127.0.0.1:{}/camera", ntohs(address.sin_port)));
    ASSERT_TRUE(source);
    std::thread waiting([&] {
        SourceFrame frame;
        const auto more = (*source)->advance(frame);
        EXPECT_TRUE(more && !*more);
    });
    const int connection = ::accept(listener, nullptr, nullptr);
    (*source)->interrupt();
    waiting.join();
    ::close(connection);
    ::close(listener);
}

TEST(NetworkCamera, AddressesAreShownWithoutPasswords) {
    EXPECT_EQ(shown_address("rtsp://user:p@ss@camera:554/a@b"), "rtsp://camera:554/a@b");
    EXPECT_EQ(shown_address("http://camera/x?user=a&pwd=b@c"), "http://camera/x");
    EXPECT_EQ(shown_address("rtsp://user:pa/ss#w@camera/stream"), "rtsp://camera/stream");
    EXPECT_EQ(shown_address("rtsp://camera:554/a@b"), "rtsp://camera:554/a@b");
    EXPECT_EQ(shown_address("/dev/video0"), "/dev/video0");
    const auto refused = open_source(fmt::format("http://user:secret@127.0.0.1:{}/", free_port()));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().message.find("secret"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace roomfix
