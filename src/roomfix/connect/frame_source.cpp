#include "roomfix/connect/frame_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

#include "roomfix/base/number.hpp"
#include "roomfix/connect/network_camera.hpp"
#include "roomfix/connect/reconnecting_source.hpp"
#include "roomfix/connect/time_errors.hpp"
#include "roomfix/connect/v4l2_camera.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/imaging/y4m.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

bool is_picture(const fs::path& file) {
    std::string ending = file.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return ending == ".jpg" || ending == ".jpeg" || ending == ".png" || ending == ".pgm" || ending == ".ppm" || ending == ".bmp" || ending == ".y4m";
}

Result<PictureFile> file_as_it_is(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    PictureFile picture{{std::istreambuf_iterator<char>(stream), {}}, file.extension().string().substr(1)};
    if (picture.bytes.empty()) return Error{fmt::format("{}: cannot be read", file.string())};
    return picture;
}

Result<PictureFile> encoded(const cv::Mat& picture, const char* ending, const std::vector<int>& options) {
    PictureFile file{{}, ending};
    try {
        if (cv::imencode(std::string(".") + ending, picture, file.bytes, options)) return file;
    } catch (const cv::Exception&) {
    }
    return Error{fmt::format("a picture of {} x {} pixels cannot be encoded as {}", picture.cols, picture.rows, ending)};
}

class FolderSource : public FrameSource {
public:
    FolderSource(std::vector<fs::path> files, std::vector<TimeErrorChange> time_errors) : files_(std::move(files)), time_errors_(std::move(time_errors)) {}

    Result<bool> advance(SourceFrame& frame) override {
        if (next_ == files_.size()) return false;
        const fs::path& file = files_[next_];
        const auto stamp = parse_integer(file.stem().string());
        frame.time = stamp ? *stamp : from_seconds(0.1 * static_cast<double>(next_));
        frame.time_error = time_error_at(time_errors_, frame.time);
        frame.name = file.filename().string();
        ++next_;
        return true;
    }
    Result<void> decode(SourceFrame& frame) override {
        if (keeps_files_) frame.file = [file = files_[next_ - 1]] { return file_as_it_is(file); };
        return load_picture(files_[next_ - 1], frame.image, frame.colour, buffer_);
    }
    bool live() const override { return false; }
    std::int64_t count() const override { return static_cast<std::int64_t>(files_.size()); }
    void keep_files() override { keeps_files_ = true; }

private:
    bool keeps_files_ = false;
    std::vector<fs::path> files_;
    std::vector<TimeErrorChange> time_errors_;
    std::size_t next_ = 0;
    std::vector<std::uint8_t> buffer_;
};

class VideoSource : public FrameSource {
public:
    explicit VideoSource(cv::VideoCapture capture) : capture_(std::move(capture)) {
        const double rate = capture_.get(cv::CAP_PROP_FPS);
        if (rate > 0.1 && rate < 1000) interval_ = 1 / rate;
        count_ = std::llround(std::clamp(capture_.get(cv::CAP_PROP_FRAME_COUNT), 0.0, 1e9));
    }

    Result<bool> advance(SourceFrame& frame) override {
        try {
            if (!capture_.grab()) return false;
        } catch (const cv::Exception& problem) {
            return Error{fmt::format("the video cannot be read on: {}", problem.err)};
        }
        frame.time = from_seconds(interval_ * static_cast<double>(number_));
        frame.name = std::to_string(++number_);
        return true;
    }
    Result<void> decode(SourceFrame& frame) override {
        try {
            if (!capture_.retrieve(picture_) || picture_.empty()) return Error{fmt::format("frame {} of the video cannot be decoded", frame.name)};
        } catch (const cv::Exception& problem) {
            return Error{fmt::format("frame {} of the video cannot be decoded: {}", frame.name, problem.err)};
        }
        if (keeps_files_) {
            frame.file = [picture = picture_.clone()] { return encoded(picture, "png", {cv::IMWRITE_PNG_COMPRESSION, 1}); };
        }
        const auto converted = luma_from_mat(picture_, frame.image);
        if (!converted) return converted.error();
        return colour_from_mat(picture_, frame.colour);
    }
    bool live() const override { return false; }
    std::int64_t count() const override { return count_; }
    void keep_files() override { keeps_files_ = true; }

private:
    bool keeps_files_ = false;
    cv::VideoCapture capture_;
    cv::Mat picture_;
    double interval_ = 0.1;
    std::int64_t number_ = 0;
    std::int64_t count_ = -1;
};

Result<std::unique_ptr<FrameSource>> open_folder(const fs::path& folder) {
    std::vector<fs::path> files;
    std::error_code failure;
    for (const auto& entry : fs::directory_iterator(folder, failure)) {
        if (entry.is_regular_file(failure) && is_picture(entry.path())) files.push_back(entry.path());
    }
    if (failure) return Error{fmt::format("{}: the folder cannot be read: {}", folder.string(), failure.message())};
    if (files.empty() && !fs::exists(folder / no_frames_mark, failure))
        return Error{fmt::format("{}: no picture in this folder: put .jpg or .png files there", folder.string())};
    std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
        const auto x = parse_integer(a.stem().string());
        const auto y = parse_integer(b.stem().string());
        return x && y ? *x < *y : a.filename() < b.filename();
    });
    std::vector<TimeErrorChange> time_errors;
    if (const fs::path file = folder / time_errors_name; fs::exists(file, failure)) {
        auto read = read_time_errors(file);
        if (!read) return read.error();
        time_errors = std::move(*read);
    }
    return std::unique_ptr<FrameSource>(std::make_unique<FolderSource>(std::move(files), std::move(time_errors)));
}

/// What opens a live camera; nothing for a recording.
SourceOpener live_opener(const std::string& source, const LiveSettings& settings) {
    using Opened = Result<std::unique_ptr<FrameSource>>;
    if (is_network_address(source)) {
        const auto clock = std::make_shared<StreamClock>(settings.capture.delay);
        return [=](const std::atomic<bool>& stop) -> Opened { return open_network_camera(source, clock, stop); };
    }
    if (is_video_device(source)) {
        return [=](const std::atomic<bool>&) -> Opened { return open_v4l2_camera(source, settings); };
    }
    return {};
}

}  // namespace

std::function<Result<PictureFile>()> yuv_file(const YuvView& picture) {
    auto bytes = encode_y4m(picture);
    if (!bytes) return {};
    const auto file = std::make_shared<PictureFile>(PictureFile{std::move(*bytes), "y4m"});
    return [file] { return std::move(*file); };
}

Result<PictureFile> grey_file(const LumaImage& image) {
    const LumaView view = image.view();
    const cv::Mat grey(view.height, view.width, CV_8UC1, const_cast<std::uint8_t*>(view.data), static_cast<std::size_t>(view.stride));
    return encoded(grey, "png", {cv::IMWRITE_PNG_COMPRESSION, 1});
}

Result<bool> FrameSource::next(SourceFrame& frame) {
    const auto more = advance(frame);
    if (!more || !*more) return more;
    if (const auto decoded = decode(frame); !decoded) return decoded.error();
    return true;
}

Result<std::unique_ptr<FrameSource>> open_source(const std::string& source, const LiveSettings& settings) {
    static const std::atomic<bool> never{false};  // cameras look at it as long as they are there
    if (const auto opener = live_opener(source, settings)) return opener(never);
    std::error_code failure;
    const fs::path path(source);
    if (!fs::exists(path, failure)) return Error{fmt::format("{}: does not exist: check 'source' in the site file", source)};
    if (fs::is_directory(path, failure)) return open_folder(path);
    if (is_picture(path)) return std::unique_ptr<FrameSource>(std::make_unique<FolderSource>(std::vector{path}, std::vector<TimeErrorChange>{}));
    try {
        cv::VideoCapture capture;
        capture.setExceptionMode(false);
        // A named backend: any other way OpenCV asks all drivers it knows, photo cameras too, for something of that name.
        if (capture.open(source, cv::CAP_FFMPEG)) return std::unique_ptr<FrameSource>(std::make_unique<VideoSource>(std::move(capture)));
    } catch (const cv::Exception&) {
    }
    return Error{fmt::format("{}: not a video that can be read: convert it to MJPEG or H.264", source)};
}

Result<std::unique_ptr<FrameSource>> open_lasting_source(const std::string& source, const LiveSettings& settings) {
    if (auto opener = live_opener(source, settings)) return std::unique_ptr<FrameSource>(std::make_unique<ReconnectingSource>(std::move(opener)));
    return open_source(source, settings);
}

}  // namespace roomfix
