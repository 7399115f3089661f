#include "roomfix/ceiling/lamps.hpp"

#include "roomfix/imaging/components.hpp"

namespace roomfix {

std::vector<LampBox> find_lamps(LumaView frame, int threshold, int least_area) {
    BitMask bright(frame.width, frame.height);
    for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
            if (frame.at(x, y) >= threshold) bright.set(x, y);
        }
    }
    ComponentFinder finder;
    std::vector<LampBox> lamps;
    for (const Component& c : finder.find(bright, least_area)) lamps.push_back({c.left, c.top, c.right, c.bottom});
    return lamps;
}

}  // namespace roomfix
