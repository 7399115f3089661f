#include "roomfix/pipeline/joint_bodies.hpp"

#include <algorithm>

namespace roomfix {

std::string JointSighting::source() const {
    std::string name;
    for (const std::string& camera : cameras) name += (name.empty() ? "" : "+") + camera;
    return name;
}

std::vector<JointSighting> JointBodies::find(const std::vector<CameraPost*>& posts) {
    std::vector<JointSighting> sightings;
    std::vector<SeenBy> moment;
    std::vector<char> wanted;
    for (const SiteRobot& robot : robots_) wanted.push_back(!robot.many);
    for (CameraPost* post : posts) {
        moment.push_back({&post->view(), &post->evidence()});
        for (const SilhouetteObservation& o : post->outlines()) {
            if (!o.doubtful) wanted[static_cast<std::size_t>(o.robot)] = 0;
        }
        for (std::size_t r = 0; r < robots_.size(); ++r) {
            if (post->sees_tag_of(static_cast<int>(r))) wanted[r] = 0;
        }
    }
    for (const BodySighting& body : observer_.find(moment, wanted)) {
        const Body& shape = observer_.body(body.robot);
        bool exact = false;
        for (std::size_t c = 0; c < posts.size(); ++c) {
            const auto& outlines = posts[c]->outlines();
            const auto outline = std::find_if(outlines.begin(), outlines.end(), [&](const auto& o) { return o.robot == body.robot; });
            if (outline == outlines.end()) continue;
            if (observer_.agrees(moment, body.robot, outline->pose, body.place)) {
                exact = true;
            } else {
                posts[c]->replace_outline(body.robot, nullptr);
            }
        }
        if (exact) continue;
        JointSighting sighting;
        for (std::size_t c = 0; c < posts.size(); ++c) {
            if (!body.place.seen[c]) continue;
            sighting.cameras.push_back(posts[c]->id());
            const SilhouetteObservation drawn = observation_of(body, shape, posts[c]->view());
            posts[c]->replace_outline(body.robot, &drawn);
            sighting.pose = poses_of({drawn}).front();
        }
        if (!sighting.cameras.empty()) sightings.push_back(sighting);
    }
    return sightings;
}

}  // namespace roomfix
