#include "numpy_picture.hpp"

#include <fmt/format.h>

#include <cstring>
#include <opencv2/core/mat.hpp>
#include <utility>
#include <vector>

#include "roomfix/imaging/load_luma.hpp"

namespace roomfix {

namespace py = pybind11;

NumpyPicture picture_of(const py::array& array, const std::string& order) {
    const bool grey = array.ndim() == 2;
    if (!py::isinstance<py::array_t<std::uint8_t>>(array) || !(grey || (array.ndim() == 3 && array.shape(2) == 3)) || array.size() == 0) {
        throw py::value_error("a picture must be an array of uint8, height x width (grey) or height x width x 3 (colour)");
    }
    if (order != "rgb" && order != "bgr") throw py::value_error(fmt::format("order is '{}': it must be 'rgb' or 'bgr'", order));
    const auto packed = py::array_t<std::uint8_t, py::array::c_style>::ensure(array);
    const int height = static_cast<int>(packed.shape(0)), width = static_cast<int>(packed.shape(1));
    std::vector<std::uint8_t> pixels(packed.data(), packed.data() + packed.size());
    if (!grey && order == "rgb") {
        for (std::size_t i = 0; i + 2 < pixels.size(); i += 3) std::swap(pixels[i], pixels[i + 2]);
    }
    const cv::Mat mat(height, width, grey ? CV_8UC1 : CV_8UC3, pixels.data());
    NumpyPicture picture;
    for (const Result<void>& read : {luma_from_mat(mat, picture.grey), colour_from_mat(mat, picture.colour)}) {
        if (!read) throw py::value_error(read.error().message);
    }
    return picture;
}

py::array_t<std::uint8_t> array_of(LumaView grey) {
    py::array_t<std::uint8_t> array({grey.height, grey.width});
    for (int y = 0; y < grey.height; ++y) std::memcpy(array.mutable_data(y, 0), grey.row(y), static_cast<std::size_t>(grey.width));
    return array;
}

}  // namespace roomfix
