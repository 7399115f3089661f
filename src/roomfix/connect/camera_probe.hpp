// What a camera gives, found out by looking.
#pragma once

#include <string>
#include <vector>

#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/video_device.hpp"

namespace roomfix {

struct CameraProbe {
    SourceFrame picture;
    double rate = 0;   // pictures per second
    std::string note;  // what the camera's source says of itself
};

/// Takes pictures for some seconds. An error says why there is none, and what to do.
Result<CameraProbe> probe_camera(const std::string& source);

/// The first picture of a camera or of a recording. An error says why there is none.
Result<SourceFrame> first_picture(const std::string& source);

/// Lines for people: which camera it is, by which names it is found again, in which sizes, formats and rates it gives pictures.
std::string description_of(const VideoDeviceInfo& camera);
std::string description_of(const std::string& source, const CameraProbe& camera);

/// Writes a picture by its file's ending; a JPEG as the camera gave it, where it gave one.
Result<void> save_picture(const std::string& file, const SourceFrame& picture);

}  // namespace roomfix
