// Calibrations as users of simulated cameras would do them: from rendered pictures of a board, from a robot that turns or drives.
#pragma once

#include <cstdint>
#include <vector>

#include "roomfix/calibrate/lens.hpp"
#include "roomfix/calibrate/mount.hpp"
#include "roomfix/simulate/scenario.hpp"
#include "roomfix/simulate/sensor.hpp"

namespace roomfix {

/// The pictures from which an experiment calibrates its lenses.
struct BoardPictures {
    int shots = 60;
    bool flat = false;  // printed exactly, flat and still; otherwise as people make boards and hold them
};

/// The lens from rendered pictures of a board before the camera.
Result<LensCalibration> photographed_lens(const CameraModel& truth, const SensorModel& sensor, std::uint64_t seed, const BoardPictures& pictures);

/// A fixed camera's pose from the joints of the rendered floor, starting from floor points that somebody clicked. `known`: the camera as
/// its user describes it, with those points; its lens may be known or not.
Result<KnownPose> photographed_floor(const ScenarioCamera& truth, const Scene& scene, const SiteCamera& known, double tile, std::uint64_t seed);

/// The mount from rendered pictures of a scenario with a camera that looks up: from its robot's turn on the spot (with a wobble of some
/// millimetres), or from its drive where it has wheels. `model`: the camera's, as far as it is known.
Result<MountCalibration> photographed_mount(const Scenario& scenario, const CameraModel& model, const IntrinsicsErrors& intrinsics,
                                            const MountSettings& settings, std::uint64_t seed);

/// What a camera sees of the kim2011 room's landmark, straight from geometry with normal noise (px): from a turn on the spot that covers
/// `range` (rad) with a wobble (m), and from a drive around it with wheels. Each frame's pose is a rough guess.
std::vector<MountFrame> seen_turn(const CameraOnRobot& truth, double range, int count, double noise, double wobble, Random& random);
struct SeenDrive {
    std::vector<MountFrame> frames;
    OdometryTrack wheels;
};
SeenDrive seen_drive(const CameraOnRobot& truth, double noise, std::uint64_t seed);

}  // namespace roomfix
