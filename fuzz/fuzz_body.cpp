// Any text as a learned body: an error, or a body that can be looked for and written again.
#include <string>

#include "roomfix/overhead/body.hpp"
#include "roomfix/site/body_parts.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
    auto body = roomfix::parse_learned_body({reinterpret_cast<const char*>(data), size}, "fuzz.body");
    if (!body) return 0;
    (void)roomfix::parse_learned_body(roomfix::learned_body_text(*body), "again.body");
    roomfix::SiteRobot robot;
    robot.parts = body->parts;
    robot.shape = roomfix::box_around(robot.parts);
    robot.learned = std::make_shared<const roomfix::LearnedBody>(std::move(*body));
    (void)roomfix::body_of(robot);
    return 0;
}
