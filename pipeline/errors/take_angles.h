// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "datasets/results/stored_take.h"
#include "pipeline/errors/track_samples.h"

namespace trilat {

// Joint angles of a take and their errors, left and right together: knee, elbow and hip flexion, and the
// trunk's inclination where y is up, where the take's joints have their points; before any alignment, which
// turns no angle or, joint by joint, spoils it. Formulas: evaluators/metrics/body_metrics.h.
class TakeAngles {
 public:
  explicit TakeAngles(const TakeHead& head);
  const std::vector<std::string>& names() const { return names_; }
  void add(const Window& w);

  // Gives sums by angle and method, which the caller begins anew.
  using Put = std::function<void(ErrorSums& sums, std::size_t angle, std::size_t method, Measure measure)>;
  void end_block(const Put& put);
  void end_take(const Put& put);

 private:
  // One angle of one side, by its points; the trunk's has the middles of two each.
  struct Angle {
    std::size_t name;
    std::vector<std::size_t> joints;  // three; of the trunk both hips and both shoulders
  };
  struct Extremes {
    double least = kNaN, largest = kNaN;
    void add(double value);
    double range() const { return largest - least; }
  };
  struct Sums {
    ErrorSums error, truth;      // of the block
    Extremes estimates, truths;  // of the take
  };
  std::vector<std::string> names_;
  std::vector<Angle> angles_;
  std::size_t methods_;
  std::vector<Sums> sums_;  // by name and method
};

}  // namespace trilat
