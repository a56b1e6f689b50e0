// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/results/summary.h"

namespace trilat {

inline SummaryCell cell_of(const std::string& method, const std::string& group, double mae_m,
                           std::uint64_t answered = 75) {
  SummaryCell cell;
  cell.method = method;
  cell.condition = "walking";
  cell.group = group;
  cell.alignment = "mean";
  cell.asked = 100;
  cell.answered = answered;
  cell.statuses = {{"converged", answered}};
  if (answered < 100) cell.statuses["too_few_ranges"] = 100 - answered;
  cell.mae_m = mae_m;
  return cell;
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
    summary.cells.push_back(cell_of("nonlinear", summary.groups[g], nonlinear_m[g]));
    summary.cells.push_back(cell_of("mean", summary.groups[g], 0.05, 100));
  }
  return summary;
}

}  // namespace trilat
