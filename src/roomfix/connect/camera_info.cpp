#include "roomfix/connect/camera_info.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <vector>

#include "roomfix/base/number.hpp"
#include "roomfix/base/text_file.hpp"

namespace roomfix {
namespace {

constexpr double largest = 32768;  // px

std::optional<double> number_in(const YAML::Node& node) {
    if (!node.IsDefined() || !node.IsScalar()) return std::nullopt;
    std::string text = node.Scalar();
    if (!text.empty() && text.back() == '.') text += '0';  // OpenCV writes "0."
    const auto dot = text.find(".e");
    if (dot != std::string::npos) text.insert(dot + 1, "0");
    return parse_number(text);
}

/// The numbers under key.data.
Result<std::vector<double>> data_of(const YAML::Node& root, const char* key) {
    const YAML::Node matrix = root[key];
    const YAML::Node data = matrix.IsDefined() && matrix.IsMap() ? matrix["data"] : YAML::Node();
    if (!data.IsDefined() || !data.IsSequence()) return Error{fmt::format("{}.data is missing, or no list: is this a camera_info file?", key)};
    std::vector<double> numbers;
    for (const auto& item : data) {
        const auto value = number_in(item);
        if (!value) return Error{fmt::format("{}.data has an entry that is no number", key)};
        numbers.push_back(*value);
    }
    return numbers;
}

std::string matrix_text(const char* key, int rows, const std::vector<double>& values) {
    std::string data;
    for (const double v : values) data += (data.empty() ? "" : ", ") + number_text(v);
    return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: [{}]\n", key, rows, values.size() / static_cast<std::size_t>(rows), data);
}

Result<CameraInfo> read(const YAML::Node& root) {
    const auto has_text = [&](const char* key) { return root[key].IsDefined() && root[key].IsScalar(); };
    const auto width = number_in(root["image_width"]), height = number_in(root["image_height"]);
    if (!width || !height || *width < 1 || *height < 1 || *width > largest || *height > largest || *width != std::round(*width) ||
        *height != std::round(*height)) {
        return Error{"image_width and image_height must be whole numbers of pixels"};
    }
    const auto matrix = data_of(root, "camera_matrix");
    if (!matrix) return matrix.error();
    const auto numbers = data_of(root, "distortion_coefficients");
    if (!numbers) return numbers.error();
    const auto& k = *matrix;
    if (k.size() != 9 || k[0] <= 0 || k[4] <= 0) return Error{"camera_matrix.data must have nine numbers, with positive focal lengths"};
    if (k[1] != 0) return Error{"camera_matrix has a skew, which roomfix does not model: calibrate without"};
    // Files of OpenCV do not name the model: the number of coefficients does.
    const std::string name = has_text("distortion_model") ? root["distortion_model"].Scalar() : numbers->size() == 8 ? "rational_polynomial" : "plumb_bob";
    const auto kind = distortion_named(name == "fisheye" ? "equidistant" : name);
    if (!kind) return Error{fmt::format("distortion_model is '{}': plumb_bob, rational_polynomial and equidistant can be used", name)};
    const auto most = static_cast<std::size_t>(distortion_count(*kind));
    if (numbers->size() > most) return Error{fmt::format("{} distortion coefficients, {} has {}", numbers->size(), name, most)};
    std::array<double, most_distortion> distortion = {};
    std::copy(numbers->begin(), numbers->end(), distortion.begin());
    CameraInfo info;
    if (has_text("camera_name")) info.name = root["camera_name"].Scalar();
    info.model = make_camera_model(static_cast<int>(*width), static_cast<int>(*height), k[0], k[4], k[2], k[5], distortion, *kind);
    return info;
}

}  // namespace

Result<CameraInfo> parse_camera_info(std::string_view text) {
    // OpenCV's first line is not YAML.
    if (text.starts_with("%YAML:")) text.remove_prefix(std::min(text.find('\n'), text.size()));
    try {
        const YAML::Node root = YAML::Load(std::string(text));
        if (!root.IsMap()) return Error{"not a camera_info file: it has no keys"};
        return read(root);
    } catch (const YAML::Exception& problem) {
        return Error{fmt::format("line {}: not valid YAML: {}", problem.mark.line + 1, problem.msg)};
    }
}

Result<CameraInfo> load_camera_info(const std::filesystem::path& file) {
    const auto text = read_text(file);
    if (!text) return text.error();
    auto info = parse_camera_info(*text);
    if (!info) return Error{fmt::format("{}: {}", file.string(), info.error().message)};
    return info;
}

std::string camera_info_text(const CameraInfo& info) {
    const CameraModel& m = info.model;
    const auto* d = m.distortion.data();
    return fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", m.width, m.height, info.name) +
           matrix_text("camera_matrix", 3, {m.fx, 0, m.cx, 0, m.fy, m.cy, 0, 0, 1}) + fmt::format("distortion_model: {}\n", name_of(m.kind)) +
           matrix_text("distortion_coefficients", 1, std::vector<double>(d, d + distortion_count(m.kind))) +
           matrix_text("rectification_matrix", 3, {1, 0, 0, 0, 1, 0, 0, 0, 1}) +
           matrix_text("projection_matrix", 3, {m.fx, 0, m.cx, 0, 0, m.fy, m.cy, 0, 0, 0, 1, 0});
}

}  // namespace roomfix
