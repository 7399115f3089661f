// Any bytes as a picture of a corner, with and without a prediction: a corner or a reason, never a crash.
#include <algorithm>
#include <numbers>

#include "roomfix/corner/chou1986.hpp"
#include "roomfix/corner/corner_observer.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
    using namespace roomfix;
    if (size < 4) return 0;
    // The picture is the bytes, row by row, over and over; the first ones choose its size.
    const int width = 1 + 2 * data[0];
    const int height = 1 + data[1];
    const CameraModel model =
        make_camera_model(width, height, 40.0 + data[2], 40.0 + data[2], 0.5 * width, 0.5 * height, {0.002 * (data[3] - 128), 0, 0, 0, 0});
    LumaImage picture(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) picture.row(y)[x] = data[(static_cast<std::size_t>(y / 3) * 61 + static_cast<std::size_t>(x / 3)) % size];
    }
    CornerObserver observer(model, {std::numbers::pi / 2, 1.9});
    CornerResult result;
    observer.observe(picture, {}, result);
    CornerHints hints;
    CornerView view;
    view.corner_from_camera << -0.7071, 0.35, -0.61, 0.7071, 0.35, -0.61, 0, -0.87, 0.5;
    view.place = {0.01 * data[0], 0.01 * data[1] + 0.1};
    hints.expected.push_back({view, std::numbers::pi / 2, 2});
    hints.gravity = Gravity{{0, 0.9, -0.4}, 0.1};
    observer.observe(picture, hints, result);
    (void)Chou1986(model).locate(picture);
    return 0;
}
