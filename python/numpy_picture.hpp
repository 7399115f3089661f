// Pictures as Python has them, as roomfix looks at them.
#pragma once

#include <pybind11/numpy.h>

#include <string>

#include "roomfix/imaging/colour_image.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// A picture with its memory.
struct NumpyPicture {
    LumaImage grey;
    ColourImage colour;

    PictureView view() const { return {grey, &colour}; }
};

/// `array`: uint8, height x width (grey) or height x width x 3, whose channels are in the order `order`: "rgb" or "bgr". Throws py::value_error, which says
/// what is wrong, for anything else.
NumpyPicture picture_of(const pybind11::array& array, const std::string& order);

/// A grey picture as an array, height x width.
pybind11::array_t<std::uint8_t> array_of(LumaView grey);

}  // namespace roomfix
