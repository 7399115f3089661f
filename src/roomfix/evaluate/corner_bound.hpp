// How well could a picture tell a corner's pose at all? The Cramer-Rao bound of its three edges.
#pragma once

#include <Eigen/Core>

#include "roomfix/observation/corner_observation.hpp"
#include "roomfix/simulate/room_shots.hpp"

namespace roomfix {

/// What the edges of the shot's corner tell about rotation (corner's axes, rad) and place, once the light on both sides of each stretch of
/// edge, its slope and its change of slope are estimated with it. Nobody knows what else is in the room: only the edges count. The walls
/// meet at a right angle.
Matrix5d corner_information(const RoomShot& shot, const CameraModel& model, const SensorModel& sensor, const GlareModel& glare);

/// The true view of a shot's corner.
CornerView true_view(const RoomShot& shot);

}  // namespace roomfix
