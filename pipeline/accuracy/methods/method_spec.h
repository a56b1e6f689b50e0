// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "evaluators/ceres/ceres_trilateration.h"
#include "evaluators/fusion/baselines.h"
#include "evaluators/fusion/bone_smoother.h"
#include "evaluators/fusion/kalman.h"
#include "evaluators/fusion/range_bearing.h"
#include "evaluators/solvers/geometric.h"
#include "evaluators/solvers/linear.h"
#include "evaluators/solvers/nonlinear.h"

namespace trilat {

struct MethodKind;

// Which sensors a method leaves out because they see a joint occluded: by crossing limbs as the paper prints
// it (eq. 8), by crossing limbs in the perspective image, those alone that infer the joint, or those from
// whom it is truly hidden, which simulations alone know.
enum class OcclusionRule : std::uint8_t { off, printed, corrected, inferred, hidden };
inline constexpr std::size_t kOcclusionRules = 5;
template <>
inline constexpr std::array words<OcclusionRule>{"off", "printed", "corrected", "inferred", "hidden"};

// One method with its settings, before it is known which sensors the rig has. Only the options of its own
// kind count.
struct MethodSpec {
  const MethodKind* kind = nullptr;  // one of method_kinds()
  std::string name;                  // of its rows; unique in the study
  std::vector<std::string> sensors;  // those it may use; empty: all. geometric uses the first three
  std::uint64_t each = 0;        // of these many sensors in turn, every set or most_sets of them; 0: of all
  std::uint64_t most_sets = 12;  // sets of one size are first parts of the same orders of all sensors
  std::string family;            // of a method that stands for one set: the name of the study's entry
  std::string reference;         // linear: the reference sensor; empty: the first
  LinearOptions linear;
  NonlinearOptions nonlinear;  // of nonlinear and newton
  CeresOptions ceres;
  OcclusionRule occlusion = OcclusionRule::off;
  bool inferred_is_occluded = true;  // an inferred joint counts as one crossing more
  int fewest_sensors = 1;            // those with the fewest crossings come back until there are as many
  RangeBearingOptions range_bearing;
  MeanOptions mean;                 // without its sensors
  bool sigma_is_estimated = false;  // range_bearing: from the take itself, without truth
  // Poses and range offsets are estimated again from the take itself, without ground truth, without truth.
  bool calibration_is_estimated = false;
  KalmanOptions kalman;       // of kalman and rts
  BoneSmootherOptions bones;  // of window

  static void fields(MethodSpec& m, Fields& f);
  void check(const JsonPlace& place) const;
  static std::vector<MethodSpec> alternatives();  // one a kind
};

// Whether the method needs to know which joints are hidden.
inline bool asks_for_hidden(const MethodSpec& spec) { return spec.occlusion == OcclusionRule::hidden; }

// Source of a setting: the study or calibration, or the take itself.
inline const std::vector<std::string> kStatedOrEstimated{"stated", "estimated"};

}  // namespace trilat
