// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/results/stored_take.h"

namespace trilat {

// How far one method's joint angles are from the truth's in one take, left and right together: sums over the
// instants at which both have it, in radians, estimate - truth; and between which ends each of them moves.
struct AngleSums {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::string participant, condition, angle, method;
  std::uint64_t n = 0;
  double error = 0.0, error2 = 0.0, absolute = 0.0, truth = 0.0;
  double truth_least = kNone, truth_most = kNone, least = kNone, most = kNone;

  TRILAT_FIELDS(participant, condition, angle, method, n, error, error2, absolute, truth, truth_least,
                truth_most, least, most)
};

// Knee, elbow and hip flexion, and trunk inclination, where a take's names have their points; before any
// alignment, which turns no angle or, joint by joint, spoils it. Formulas: evaluators/metrics/joint_angles.h.
class AngleErrors {
 public:
  // `level`: whether y is up, without which nothing leans.
  AngleErrors(const TakeHead& head, const std::string& participant, bool level);
  void add(const SampleBlock& block);
  // Those with any instant.
  std::vector<AngleSums> sums() const;

 private:
  // An angle of one side, by the places of its points; the trunk's has the middles of two each.
  struct Angle {
    std::string name;
    std::vector<std::size_t> points;  // three; of the trunk both hips and both shoulders
  };
  std::vector<Angle> angles_;
  std::vector<std::string> names_;  // of the angles, each once
  std::size_t joints_, methods_;
  std::vector<bool> usable_;     // by status
  std::vector<AngleSums> sums_;  // by name and method
};

}  // namespace trilat
