// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/synthetic/motion.h"

namespace trilat {

// Movement of a generated person, after the paper's experiments: `walking` with arm swing on a small circle
// (Table III, four laps in 35 s), `arm_swing` standing (Table II, experiment 1: two swings in 6 s) and
// `leg_crossing` (Table II, experiment 2: four crossing steps in 7 s).
enum class Activity { walking, arm_swing, leg_crossing, standing, steps, walk_and_stop };
template <>
inline constexpr std::array words<Activity>{"walking",  "arm_swing", "leg_crossing",
                                            "standing", "steps",     "walk_about"};

// A body and its habits. Segment lengths are fractions of the stature (Drillis and Contini 1966, as tabulated
// in Winter, "Biomechanics and Motor Control of Human Movement").
struct Person {
  double stature_m = 1.70;
  double tempo = 1.0;      // scales the pace of every movement
  double amplitude = 1.0;  // scales the swing of limbs
  double phase_rad = 0.0;  // where in the cycle the motion starts
};

// Person number `index` of a campaign; stature uniform in mean +- half range (paper: 170 +- 17 cm), tempo and
// amplitude within 10 % of normal.
Person draw_person(std::uint64_t seed, std::uint64_t index, double stature_mean_m,
                   double stature_half_range_m);

// Smooth in time, so that it may be sampled at any rate. All 25 joints. Who walks or steps stands on one foot
// at least, which does not move.
Motion generated_motion(const Person& person, Activity activity);

}  // namespace trilat
