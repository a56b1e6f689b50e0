// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/results/summary.h"

namespace trilat {

// Adds the errors of a method of which 100 samples are asked, and how these ended.
inline void add_error(ResultsSummary& summary, const std::string& method, const std::string& group,
                      double mean_m, std::uint64_t answered = 75) {
  const NumberKey key{.condition = "walking", .group = group, .method = method, .alignment = "mean"};
  const auto add = [&](const char* measure, const char* statistic, double value, std::uint64_t n) {
    summary.numbers.add({key.with({.measure = measure, .statistic = statistic}), value, kNaN, kNaN, n});
  };
  const double share = static_cast<double>(answered) / 100.0;
  add("distance", "mean", mean_m, answered);
  add("answered", "share", share, 100);
  add("status", "converged", share, answered);
  if (answered < 100) add("status", "too_few_ranges", 1.0 - share, 100 - answered);
}

// Two methods in the paper's four groups; nonlinear at 1, 2, 3 and 6 cm.
inline ResultsSummary hand_made_summary() {
  ResultsSummary summary;
  summary.study = "table3";
  summary.campaign = "hand made";
  summary.simulated = true;
  summary.takes = 2;
  summary.participants = 2;
  summary.methods = {"nonlinear", "mean"};
  summary.conditions = {"walking"};
  summary.groups = {"head", "shoulder", "elbow", "wrist"};
  summary.alignments = {"mean"};
  const double nonlinear_m[] = {0.01, 0.02, 0.03, 0.06};
  for (std::size_t g = 0; g < 4; ++g) {
    add_error(summary, "nonlinear", summary.groups[g], nonlinear_m[g]);
    add_error(summary, "mean", summary.groups[g], 0.05, 100);
  }
  return summary;
}

}  // namespace trilat
