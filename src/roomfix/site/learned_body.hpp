// What a robot's body looks like, learned from pictures of it by `roomfix calibrate robot`, and the file that keeps it.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// A spot of the body's surface and its colour in the light in which it was learned.
struct LookSpot {
    Eigen::Vector3f place = Eigen::Vector3f::Zero();      // m, robot frame
    Eigen::Vector3f outwards = Eigen::Vector3f::UnitZ();  // of length 1, away from the body
    std::array<float, 3> colour{};                        // log colours (imaging/evidence.hpp): blue, green, red; or grey alone
    float sigma = 0.2f;                                   // standard deviation of each channel from sight to sight
};

/// The surface of a body, as evenly spread spots.
struct BodyLook {
    int channels = 3;
    std::vector<LookSpot> spots;
};

/// How well looks agree with what is seen (nats per spot): mean and standard deviation from moment to moment.
struct Agreement {
    double mean = 0;
    double sigma = 1;
};

/// The whole of a body file.
struct LearnedBody {
    std::vector<ConvexPart> parts;  // m, robot frame
    double size_sigma = 0.01;       // m: how well the parts' extent is known
    double symmetry = 0;            // rad after which it looks the same; 0: it has no direction
    BodyLook look;                  // no spots: its colours are not known
    Agreement as_robot;             // where the robot stood in the pictures that it was learned from
    Agreement as_clutter;           // where they agreed best elsewhere
    std::string learned_from;       // a line for people: how many pictures of which cameras
};

constexpr int learned_body_version = 1;
constexpr const char* learned_body_ending = ".body";

/// As YAML.
std::string learned_body_text(const LearnedBody& body);
/// An error names file, line and what is wrong; a body of another version asks to be learned again.
Result<LearnedBody> parse_learned_body(const std::string& text, const std::string& name);
Result<LearnedBody> read_learned_body(const std::filesystem::path& file);

}  // namespace roomfix
