// A first site file, to be completed by hand.
#pragma once

#include <string>
#include <vector>

namespace roomfix {

struct FirstCamera {
    std::string id;
    std::string source;
    int width = 0, height = 0;  // px
};

struct FirstRobot {
    std::string id;
    bool round = false;         // a cylinder, else a box
    std::vector<double> sizes;  // m: length, width, height; of a cylinder diameter, height
};

struct FirstSite {
    std::string name;
    double ceiling = 0;  // m
    std::vector<FirstCamera> cameras;
    std::vector<FirstRobot> robots;
};

/// Its text, with comments that say how to find out what is missing: the lenses and places of the cameras, which nobody can guess.
std::string first_site_text(const FirstSite& site);

}  // namespace roomfix
