// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/claims/claim_number.h"
#include "pipeline/errors/condition_errors.h"

namespace trilat {

// Where one method errs: in a condition, at a joint group or (empty) on average over the paper's.
struct ErrorPlace {
  std::string condition = "walking", group = {};
};

// Measures for the paper's claims of accuracy: the errors of one study under its first alignment, at
// the joint groups of which the paper prints errors in that condition. Keeps a reference to the errors.
class ErrorMeasures {
 public:
  explicit ErrorMeasures(const StudyErrors& errors) : errors_(errors) {}

  // Families are compared by way of this method.
  static constexpr const char* kVia = "nonlinear";

  // (of - against) / against, over the samples at a place that both answer. A name is that of a method; of a
  // family, whose methods are taken together; or "best of FAMILY": for each cluster the method of it that
  // does best on all others, so that no cluster is judged by whom they helped to choose.
  Measurement difference(const std::string& of, const std::string& against, const ErrorPlace& place) const;
  // The method's error at `place` against that at another: (place - other) / other.
  Measurement places(const std::string& method, const ErrorPlace& place, const ErrorPlace& other) const;
  // The error of nonlinear in the half of each joint's samples with the larger acceleration, against the
  // rest.
  Measurement abrupt() const;
  // How far the fastest of the joints goes in that time, in shares of the method's error there.
  Measurement clock_cost(const std::string& method, double clock_s) const;
  // Errors of the right wrist's height, which the paper's figure shows: the largest in a take, and the mean.
  Measurement largest_wrist_height(const std::string& method) const;
  Measurement wrist_height(const std::string& method) const;

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
  // Sums of one method's errors of the right wrist's height (m): each take's largest error, and all errors.
  struct WristHeight {
    std::string missing = {};
    ClusterSums largest_m = {}, height_m = {};
    std::size_t clusters = 0;
  };
  WristHeight wrist_height_of(const std::string& method) const;
  Measurement of_wrist(const std::string& method, const char* what, const WristHeight& errors,
                       const ClusterSums& sums) const;

  const StudyErrors& errors_;
  mutable std::map<std::pair<std::string, Subset>, std::unique_ptr<ConditionErrors>> conditions_;
};

}  // namespace trilat
