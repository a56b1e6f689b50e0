// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/claims/claim_number.h"
#include "pipeline/errors/condition_errors.h"

namespace trilat {

// Two methods to compare. A name is that of a method; of a family, whose methods are taken together; or "best
// of FAMILY": for each cluster the method of it that does best on all others, so that no cluster is judged by
// whom they helped to choose.
struct Comparison {
  std::string of, against;
  std::string condition = "walking";
  std::vector<std::string> each = {};  // joint groups, each by itself; without any the mean of the paper's
};

// Where one method errs: in a condition, at a joint group or (empty) on average over the paper's.
struct ErrorPlace {
  std::string condition = "walking", group = {};
};

// Measures for the paper's claims of accuracy: the errors of one study under its first alignment, at
// the joint groups of which the paper prints errors in that condition. Keeps a reference to the errors.
class ErrorMeasures {
 public:
  explicit ErrorMeasures(const StudyErrors& errors) : errors_(errors) {}

  // (of - against) / against, over the samples that both answer.
  Measurements difference(const Comparison& comparison) const;
  // The method's error at `place` against that at another: (place - other) / other.
  Measurements places(const std::string& method, const ErrorPlace& place, const ErrorPlace& other) const;
  // The error of nonlinear in the half of each joint's samples with the larger acceleration, against the
  // rest.
  Measurements abrupt() const;
  // How far the fastest of the joints goes in that time, in shares of the method's error there.
  Measurements clock_cost(const std::string& method, double clock_s) const;
  // Errors of the right wrist's height, which the paper's figure shows: the largest in a take, and the mean.
  Measurements wrist_deviation(const std::string& method) const;

 private:
  // How the truth of a joint group moves, and the errors in either half of its samples.
  struct Movement {
    ClusterSums abrupt_m, calm_m;
    double speed_m_s = 0.0, speeds = 0.0;
    double mean_speed_m_s() const { return speeds > 0.0 ? speed_m_s / speeds : 0.0; }
  };
  std::vector<Movement> movement(const std::vector<std::size_t>& groups) const;
  const ConditionErrors& in(const std::string& condition, Subset subset = Subset::all) const;
  std::vector<std::size_t> methods_of(const std::string& name) const;
  std::vector<std::size_t> groups_of(const ErrorPlace& place) const;
  std::string lacking_joints(const std::string& condition) const;
  std::string silence_of(const std::string& name) const;
  Measurement compared(const Comparison& comparison, const std::vector<std::size_t>& groups,
                       const std::string& group_name) const;

  const StudyErrors& errors_;
  mutable std::map<std::pair<std::string, Subset>, std::unique_ptr<ConditionErrors>> conditions_;
};

}  // namespace trilat
