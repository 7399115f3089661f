// Any text as a URDF: an error, or triangles that make a body.
#include <string>

#include "roomfix/overhead/body.hpp"
#include "roomfix/site/mesh_parts.hpp"
#include "roomfix/site/read_urdf.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
    const auto model = roomfix::parse_urdf({reinterpret_cast<const char*>(data), size}, "/nowhere/fuzz.urdf");
    if (!model) return 0;
    roomfix::SiteRobot robot;
    robot.parts = roomfix::mesh_parts(model->mesh);
    (void)roomfix::body_of(robot);
    return 0;
}
