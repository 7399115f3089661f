#include "roomfix/pipeline/joint_bodies.hpp"

#include <algorithm>

namespace roomfix {

JointSighting JointBodies::find(const std::vector<CameraPost*>& posts, const std::vector<LumaView>& frames, const Expectation& expected) {
    JointSighting together;
    std::vector<KnownRobot> known;
    std::vector<SeenBy> moment;
    std::vector<char> wanted;
    for (const SiteRobot& robot : robots_) wanted.push_back(!robot.many);
    for (CameraPost* post : posts) {
        moment.push_back({&post->view(), &post->evidence(), &walls_});
        together.source += (together.source.empty() ? "" : "+") + post->id();
        for (const SilhouetteObservation& o : post->outlines()) {
            if (!o.doubtful) wanted[static_cast<std::size_t>(o.robot)] = 0;
            known.push_back(known_by_outline(o));
        }
        for (std::size_t r = 0; r < robots_.size(); ++r) {
            if (post->sees_tag_of(static_cast<int>(r))) wanted[r] = 0;
        }
    }
    for (const BodySighting& body : observer_.find(moment, wanted, known, expected)) {
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
        if (!exact) {
            for (std::size_t c = 0; c < posts.size(); ++c) {
                if (!body.place.seen[c]) continue;
                const auto outline = posts[c]->outline_at(frames[c], body, observer_.standing());
                if (!outline || !observer_.agrees(moment, body.robot, outline->pose, body.place)) continue;
                posts[c]->add_outline(*outline);
                exact = true;
            }
        }
        if (exact) continue;
        for (std::size_t c = 0; c < posts.size(); ++c) {
            if (!body.place.seen[c]) continue;
            const SilhouetteObservation drawn = observation_of(body, shape, posts[c]->view());
            posts[c]->replace_outline(body.robot, &drawn);
        }
        together.robots.push_back(poses_of({observation_of(body, shape, posts[0]->view())}).front());
    }
    together.things = observer_.things();
    for (CameraPost* post : posts) {
        const auto& outlines = post->outlines();
        for (std::size_t i = outlines.size(); i-- > 0;) {  // from the end: each takes only itself out of the list
            const KnownRobot outline = known_by_outline(outlines[i]);
            if (!outline.sure && !observer_.holds(outline)) post->replace_outline(outline.robot, nullptr);
        }
    }
    return together;
}

}  // namespace roomfix
