#include "roomfix/pipeline/joint_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "roomfix/overhead/outline_agreement.hpp"

namespace roomfix {

/// An outline that one of the cameras found.
struct JointBodies::Outline {
    FixedCamera* camera = nullptr;
    SilhouetteObservation seen;
};

/// Outlines state millimetres. Where those of one robot in two cameras contradict each other, such robots are not the solids described: what the whole body
/// covers decides.
bool JointBodies::agree(const std::vector<Outline>& outlines) {
    constexpr double contradiction = -3;  // nats
    bool agree = true;
    for (std::size_t a = 0; a < outlines.size(); ++a) {
        for (std::size_t b = a + 1; b < outlines.size(); ++b) {
            const double nats = nats_of_agreement(outlines[a].seen, outlines[b].seen);
            outlines[a].camera->note_exactness(outlines[a].seen.robot, nats);
            outlines[b].camera->note_exactness(outlines[b].seen.robot, nats);
            agree &= nats > contradiction;
        }
    }
    return agree;
}

/// Each camera shows the robot when its own rows are exposed. Together they show it in the middle of these times, the less exactly the further they are apart
/// and the faster it moves.
void JointBodies::set_late(const std::vector<double>& late, PoseObservation& robot) {
    constexpr double fast = 1.0;     // m/s
    constexpr double turning = 1.0;  // rad/s
    if (late.empty()) return;
    const auto [first, last] = std::minmax_element(late.begin(), late.end());
    robot.late = 0.5 * (*first + *last);
    const double apart = 0.5 * (*last - *first);
    robot.covariance.diagonal() += Eigen::Vector3d(fast * fast, fast * fast, turning * turning) * (apart * apart);
}

/// Takes back outlines of one robot that contradict each other. Which of several look-alikes it is, cameras do not know.
void JointBodies::compare_outlines(const std::vector<FixedCamera*>& cameras) const {
    std::vector<Outline> left;
    for (FixedCamera* camera : cameras) {
        for (const SilhouetteObservation& seen : camera->outlines()) {
            if (!robots_[static_cast<std::size_t>(seen.robot)].many) left.push_back({camera, seen});
        }
    }
    while (!left.empty()) {
        const SilhouetteObservation first = left.front().seen;
        const auto other = std::stable_partition(left.begin(), left.end(), [&](const Outline& o) {
            return observer_.kind(o.seen.robot) == observer_.kind(first.robot) &&
                   std::hypot(o.seen.pose.x - first.pose.x, o.seen.pose.y - first.pose.y) < observer_.body(first.robot).inner_radius;
        });
        const std::vector<Outline> of_one(left.begin(), other);
        left.erase(left.begin(), other);
        if (agree(of_one)) continue;
        for (const Outline& o : of_one) o.camera->replace_outline(o.seen.robot, nullptr);
    }
}

/// Whether a robot is the very solid that is described is the same for all cameras: one alone may find its outline by chance.
void JointBodies::share_exactness(const std::vector<FixedCamera*>& cameras) const {
    for (std::size_t r = 0; r < robots_.size(); ++r) {
        const int robot = static_cast<int>(r);
        double all = 0;
        for (const FixedCamera* camera : cameras) all += camera->own_exactness(robot);
        for (FixedCamera* camera : cameras) camera->set_exactness_to_others(robot, all - camera->own_exactness(robot));
    }
}

JointSighting JointBodies::find(const std::vector<FixedCamera*>& cameras, const std::vector<LumaView>& frames, const Expectation& expected) {
    compare_outlines(cameras);
    share_exactness(cameras);
    JointSighting together;
    std::vector<KnownRobot> known;
    std::vector<SeenBy> moment;
    std::vector<char> wanted;
    for (const SiteRobot& robot : robots_) wanted.push_back(!robot.many);
    for (FixedCamera* camera : cameras) {
        moment.push_back({&camera->view(), &camera->evidence(), &walls_});
        together.source += (together.source.empty() ? "" : "+") + camera->id();
        for (const SilhouetteObservation& o : camera->outlines()) {
            if (!o.doubtful) wanted[static_cast<std::size_t>(o.robot)] = 0;
            known.push_back(known_by_outline(o));
        }
        for (std::size_t r = 0; r < robots_.size(); ++r) {
            if (camera->sees_tag_of(static_cast<int>(r))) wanted[r] = 0;
        }
    }
    for (const BodySighting& body : observer_.find(moment, wanted, known, expected)) {
        const Body& shape = observer_.body(body.robot);
        bool exact = false;
        for (std::size_t c = 0; c < cameras.size(); ++c) {
            const auto& outlines = cameras[c]->outlines();
            const auto outline = std::find_if(outlines.begin(), outlines.end(), [&](const auto& o) { return o.robot == body.robot; });
            if (outline == outlines.end()) continue;
            if (observer_.agrees(moment, body.robot, outline->pose, body.place)) {
                exact = true;
            } else {
                cameras[c]->replace_outline(body.robot, nullptr);
            }
        }
        if (!exact) {
            std::vector<Outline> found;
            for (std::size_t c = 0; c < cameras.size(); ++c) {
                if (!body.place.seen[c]) continue;
                const auto outline = cameras[c]->outline_at(frames[c], body, observer_.standing());
                if (outline && observer_.agrees(moment, body.robot, outline->pose, body.place)) found.push_back({cameras[c], *outline});
            }
            exact = !found.empty() && agree(found);
            for (std::size_t o = 0; o < found.size() && exact; ++o) found[o].camera->add_outline(found[o].seen);
        }
        if (exact) continue;
        std::vector<double> late;
        for (std::size_t c = 0; c < cameras.size(); ++c) {
            if (!body.place.seen[c]) continue;
            const SilhouetteObservation drawn = observation_of(body, shape, cameras[c]->view());
            cameras[c]->replace_outline(body.robot, &drawn);
            late.push_back(cameras[c]->late(drawn));
        }
        together.robots.push_back(poses_of({observation_of(body, shape, cameras[0]->view())}).front());
        set_late(late, together.robots.back());
    }
    together.things = observer_.things();
    together.absent = observer_.absent();
    for (FixedCamera* camera : cameras) {
        const auto& outlines = camera->outlines();
        for (std::size_t i = outlines.size(); i-- > 0;) {  // from the end: each takes only itself out of the list
            const KnownRobot outline = known_by_outline(outlines[i]);
            if (!outline.sure && !observer_.holds(outline)) camera->replace_outline(outline.robot, nullptr);
        }
    }
    return together;
}

}  // namespace roomfix
