// The first camera of the li2014 scenario with its empty aisle learned, for tests of single outlines.
#pragma once

#include <gtest/gtest.h>

#include "roomfix/imaging/background_model.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {

class FirstAisle : public ::testing::Test {
protected:
    FirstAisle(std::uint64_t scenario_seed, std::uint64_t noise_seed)
        : scenario_(li2014_scenario(scenario_seed)), renderer_(scenario_.scene, scenario_.cameras[0].truth, scenario_.cameras[0].sensor, noise_seed) {
        scenario_.robots[0].look.top = 0.10f;
        BackgroundLearner learner;
        LumaImage frame;
        for (std::uint64_t i = 0; i < 24; ++i) {
            renderer_.render({}, 1, 5000 + i, frame);
            learner.add(frame);
        }
        background_ = learner.learn();
    }

    /// `frame_` and `foreground_` of the next picture.
    void show(const std::vector<Solid>& solids) {
        renderer_.render(solids, 1, ++frames_, frame_);
        background_.classify_solid(frame_, foreground_);
    }

    Scenario scenario_;
    CameraRenderer renderer_;
    const View view_ = *fixed_view(scenario_.site.cameras[0]);
    BackgroundModel background_;
    LumaImage frame_;
    Foreground foreground_;
    std::uint64_t frames_ = 0;  // the noise of the next picture
};

}  // namespace roomfix
