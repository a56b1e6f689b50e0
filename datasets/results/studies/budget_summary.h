// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"
#include "datasets/results/summary.h"

namespace trilat {

// One method's error in one joint group with one source of error alone ("none" and "all" are sources too).
struct BudgetRow {
  std::string source, method, condition, group, alignment;
  std::uint64_t n = 0;  // answered
  double rmse_m = kNoNumber;
  double mae_m = kNoNumber;

  TRILAT_FIELDS(source, method, condition, group, alignment, n, rmse_m, mae_m)
};

// An error budget: a simulated campaign evaluated once for every source of error alone and once with all.
// Squares of independent errors add, so the root of the sum of rmse^2 over the sources is held against `all`.
struct BudgetSummary {
  static constexpr StudyKind kKind = StudyKind::error_budget;
  std::string study, campaign;
  std::uint64_t seed = 0, participants = 0;
  double calibration_sigma_m = 0.0, calibration_sigma_rad = 0.0;
  std::vector<std::string> sources;       // in their order
  std::vector<std::string> descriptions;  // of each
  std::vector<BudgetRow> rows;

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(study, campaign)
    field("simulated", true);
    TRILAT_EACH(seed, participants, calibration_sigma_m, calibration_sigma_rad, sources, descriptions, rows)
  }
  void check(const JsonObject& object) const {
    if (descriptions.size() != sources.size())
      object.refuse("descriptions", "must be as many as the sources");
  }
};

}  // namespace trilat
