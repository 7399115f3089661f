// One place: its map, cameras, robots, landmarks, beacons and corners, as plain values. SI units, frames as in the names.
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "roomfix/base/tag_family.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/geometry/floor_points.hpp"
#include "roomfix/geometry/onboard_view.hpp"
#include "roomfix/geometry/pose.hpp"
#include "roomfix/geometry/view.hpp"
#include "roomfix/site/capture.hpp"
#include "roomfix/site/outputs.hpp"

namespace roomfix {

/// Where a fixed camera is: its pose, with the covariance where the file states one.
struct KnownPose {
    UncertainPose3 map_from_camera;  // its covariance: as if the intrinsics were exact
    bool has_covariance = false;
    PoseByIntrinsics by_intrinsics = PoseByIntrinsics::Zero();  // how the pose moves with the intrinsics that it was found with
};

/// Where a fixed camera is, told by points on the floor.
struct KnownFloorPoints {
    std::vector<FloorPoint> points;
    double sigma = 0.5;  // px, noise of each clicked coordinate
};

/// A camera on a robot.
struct Mount {
    std::string robot;
    UncertainPose3 robot_from_camera;
    bool has_covariance = false;
    PoseByIntrinsics by_intrinsics = PoseByIntrinsics::Zero();
};

/// A camera of which only the height is known.
struct KnownHeight {
    double height = 0;     // m above the floor
    double sigma = 0.005;  // m
    std::string robot;     // empty: no robot is where the camera is
};

using Placement = std::variant<KnownPose, KnownFloorPoints, Mount, KnownHeight>;

struct SiteCamera {
    std::string id;
    std::string source;  // as written; resolve with source_path()
    CameraModel model;
    Placement placement;
    std::string background;                                             // as written; empty: learn from the source itself
    std::string lens_grid;                                              // as written: a file; empty: the lens is what the model says
    double time_offset_sigma = 0;                                       // s: how far its time stamps may be off; 0: not at all
    CaptureSettings capture;                                            // of a live camera
    IntrinsicsMatrix intrinsics_covariance = IntrinsicsMatrix::Zero();  // zero where the file states none

    /// All that the file says about the errors of the intrinsics.
    IntrinsicsErrors intrinsics_errors() const;
};

struct Box {
    double length = 0, width = 0, height = 0;  // m, along the robot's x, y, z
};
struct Cylinder {
    double diameter = 0, height = 0;  // m
};
using Shape = std::variant<Box, Cylinder>;

/// A convex piece of a robot's body: the hull of its points (m, robot frame).
struct ConvexPart {
    std::vector<Eigen::Vector3d> points;
};

struct LearnedBody;

/// A printed square tag. Its own frame: x to the right and y up as it is read, z out of the paper.
struct Tag {
    int number = 0;
    double size = 0;  // m, edge of the square whose corners are read: where black and white meet all around
    TagFamily family = TagFamily::tag36h11;

    bool is(TagFamily seen_family, int seen_number) const { return family == seen_family && number == seen_number; }
};

/// The listener on a robot that measures ranges to beacons.
struct Receiver {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();        // m, robot frame
    std::string source;                                        // as written: file or serial device; empty: none
    double sigma = 0.02;                                       // m, of ranges that do not state their own
    double bias_sigma = 0;                                     // m: how far all ranges may be off, and a quarter of that those of each beacon
    double scale_sigma = 0;                                    // part by which ranges may be too long or short
    std::string id;                                            // empty: the robot's only one
    Eigen::Vector3d position_sigma = Eigen::Vector3d::Zero();  // m, along each axis of the robot
};

/// A robot's own detector of landmarks: how far away they are and in which direction, as seen from the robot's origin.
struct Detector {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();        // m, robot frame: from where ranges and bearings are
    Eigen::Vector3d position_sigma = Eigen::Vector3d::Zero();  // m, along each axis
    std::string source;                                        // as written: a file; empty: none
    double range_sigma = 0.05;                                 // m, of ranges that do not state their own, level with the floor
    double bearing_sigma = 0.01;                               // rad, of bearings that do not state their own
};

/// How a robot can move: turning on two driven wheels, in any direction, or nobody knows.
enum class Drive { unknown, differential, holonomic };

/// What a robot's wheels report, and how well.
struct WheelOdometry {
    std::string source;              // as written: a file; empty: none
    double scale_sigma = 0.02;       // of the measured way: a constant part that is off
    double turn_scale_sigma = 0.02;  // of the measured turning, likewise
    double drift_sigma = 0.01;       // rad/s
};

struct SiteRobot {
    std::string id;
    Shape shape;                                 // with `parts` or `model`: the box around them, its middle above the robot's origin
    std::vector<ConvexPart> parts;               // what the body is made of; empty: the shape is the body
    std::string learned_body;                    // as written: a file of `roomfix calibrate robot`; empty: none
    std::shared_ptr<const LearnedBody> learned;  // what stands in that file; null: none
    std::string model;                           // as written: the file that the parts come from; empty: the site file itself
    double model_scale = 1;                      // m per unit of the model
    double size_sigma = 0.005;                   // m: how well the shape is known
    bool unknown = false;                        // no robot of the site at all, but whatever else stands there: never in a site file
    bool many = false;                           // any number of them, all alike
    Drive drive = Drive::unknown;
    std::optional<WheelOdometry> odometry;
    std::vector<Receiver> receivers;
    std::optional<Detector> detector;
    std::optional<Tag> tag;
    Eigen::Isometry3d robot_from_tag = Eigen::Isometry3d::Identity();

    /// The first of its receivers; null: it has none.
    const Receiver* receiver() const { return receivers.empty() ? nullptr : receivers.data(); }
    /// Index of a receiver by its id; an empty id means the first one.
    std::optional<int> receiver_index(const std::string& name) const;
};

/// Three LEDs in a right triangle: in the landmark's own x, y the right angle is at (-a/2, -b/2), the end of leg a at
/// (a/2, -b/2), the end of leg b at (-a/2, b/2).
struct LedTriangle {
    double a = 0, b = 0;  // m
};

/// A mere point, for detectors that are no cameras of the site: a post, a reflector.
struct PointMark {};

using LandmarkKind = std::variant<LedTriangle, Tag, PointMark>;

struct SiteLandmark {
    std::string id;
    LandmarkKind kind;
    Eigen::Isometry3d map_from_landmark = Eigen::Isometry3d::Identity();
    double sigma = 0.002;      // m: how well each coordinate of its position is known
    double tilt_sigma = 0.01;  // rad: of a tag, how well its turn about each of its axes is known
    std::string beacon;        // the beacon that sits there, if any
};
struct SiteBeacon {
    std::string id;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    std::string address;  // what the beacon calls itself, if not its id
};
/// Where two walls meet the ceiling.
struct SiteCorner {
    std::string id;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  // m
    double yaw = 0;                                      // rad, of its x edge: along one wall into the room
    double wall_angle = std::numbers::pi / 2;            // rad: its y edge runs so far to the left of the x edge
    double sigma = 0.005;                                // m: how well each coordinate of its position is known
    std::optional<double> moulding;                      // m: height of a moulding below the ceiling, along both walls; 0: there is none

    /// Height of the place where the edge between the walls ends, as far as it is known, m.
    double lower_edge() const { return position.z() - moulding.value_or(0); }
};

using Polyline = std::vector<Eigen::Vector2d>;

/// An area of the floor with a name.
struct SiteZone {
    std::string id;
    Polyline border;  // m, three or more corners; the last is joined to the first
};

/// A picture of the place from above, to be shown under the map.
struct SitePlan {
    std::string image;         // as written: a file
    double resolution = 0.05;  // m per pixel
    Pose2 map_from_plan;       // of the picture's lower left corner: its x runs along the lower edge, its y up the left one
};

struct Site {
    std::filesystem::path folder;  // relative paths start here
    std::string name;
    double ceiling = 0;       // m; 0: not stated
    double temperature = 20;  // degC, of the air that sound goes through
    double lost = 0.6;        // m (1 sigma, worst direction): a place known less is no fix
    std::vector<Polyline> walls;
    std::vector<SiteCamera> cameras;
    std::vector<SiteRobot> robots;
    std::vector<SiteLandmark> landmarks;
    std::vector<SiteBeacon> beacons;
    std::vector<SiteCorner> corners;
    std::vector<SiteZone> zones;
    std::optional<SitePlan> plan;
    Outputs outputs;

    /// The families of the tags on landmarks and robots, each once.
    std::vector<TagFamily> tag_families() const;
    const SiteCamera* camera(const std::string& id) const {
        for (const auto& c : cameras) {
            if (c.id == id) return &c;
        }
        return nullptr;
    }
    /// Index of a robot by its id.
    std::optional<int> robot(const std::string& id) const {
        for (std::size_t i = 0; i < robots.size(); ++i) {
            if (robots[i].id == id) return static_cast<int>(i);
        }
        return std::nullopt;
    }
};

/// A camera on a robot, as its observers and the tracker need it.
CameraOnRobot camera_on_robot(const SiteCamera& camera, const Mount& mount);

/// A path of the site file, made absolute by the site's folder. Devices and addresses (/dev/..., rtsp://...) stay.
std::string resolved_path(const Site& site, const std::string& path);

/// Where a fixed camera is, be it said by a pose or by floor points; errors and `note` as of fixed_view().
Result<KnownPose> known_pose(const SiteCamera& camera, std::string* note = nullptr);

/// The camera as a view of the map, with the covariance that its placement gives. An error for a camera on a robot or of
/// known height only, and where the floor points do not fix the pose. `note` receives a sentence worth showing, if any.
Result<View> fixed_view(const SiteCamera& camera, std::string* note = nullptr);

/// The landmark's points in its own frame: a triangle's LEDs (right angle, end of leg a, end of leg b), or a tag's corners (as
/// it is read: bottom left, bottom right, top right, top left), or the point itself.
std::vector<Eigen::Vector3d> own_points(const LandmarkKind& kind);
/// The same points in the map, m.
std::vector<Eigen::Vector3d> map_points(const SiteLandmark& landmark);

/// Landmarks that look alike from below: the same legs at the same height, or the same tag.
struct LandmarkShape {
    LandmarkKind kind;
    double height = 0;           // m, of the landmark's origin
    std::vector<int> landmarks;  // indices in the site
};
std::vector<LandmarkShape> landmark_shapes(const std::vector<SiteLandmark>& landmarks);

/// Does a wall stand between two places of the map?
bool wall_between(const std::vector<Polyline>& walls, const Eigen::Vector2d& a, const Eigen::Vector2d& b);

/// A receiver of which nobody said where it is: anywhere within the robot's box alike.
Receiver somewhere_on(const SiteRobot& robot);

/// Can the two not be told apart from afar, by shape and size, or by the bodies that their parts and models make?
bool look_alike(const SiteRobot& a, const SiteRobot& b);
/// Of each robot: its kind. Look-alikes are of one kind; the kinds are numbered as they come.
std::vector<std::size_t> kinds_of(const std::vector<SiteRobot>& robots);
/// Are they so nearly of one size that pictures may take one for the other, as long as nothing but a rough box or cylinder is known of them?
bool hard_to_tell(const SiteRobot& a, const SiteRobot& b);

/// Length of the robot along each axis: half sizes of the box around it (m).
Eigen::Vector3d half_size(const Shape& shape);

}  // namespace roomfix
