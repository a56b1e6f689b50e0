// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/claims.h"
#include "datasets/results/results_file.h"
#include "evaluators/metrics/statistics.h"

namespace trilat {

// Everything that decides the trials of one cell and how they are solved, in the words of the study.
struct SweepSetting {
  std::string rig;
  std::string joint = "volume";
  std::string error_model = "range_signed";
  std::string threshold_unit = "cm2";
  std::string gradient = "corrected", curvature = "gauss_newton", stop = "objective", damping = "none";
  std::string start = "linear";
  double threshold = 1e-4;                         // C, in its unit
  double error_low_m = 0.05, error_high_m = 0.15;  // range of the measurement errors

  TRILAT_FIELDS(rig, joint, error_model, threshold_unit, gradient, curvature, stop, damping, start, threshold,
                error_low_m, error_high_m)
};

// One cell of the sweep. NaN where nothing answered. Errors are distances to the true joint, over the
// answered trials; the iterations are over all trials.
struct SweepCell {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  SweepSetting setting;
  std::uint64_t asked = 0;                                // trials
  std::uint64_t answered = 0;                             // of those, with a usable estimate
  std::map<std::string, std::uint64_t> statuses;          // sums to asked
  double mae_m = kNone;                                   // mean Euclidean distance
  double mae_standard_error_m = kNone;                    // standard deviation / sqrt(answered)
  std::array<double, 3> axis_mae_m{kNone, kNone, kNone};  // world x, y, z
  double rmse_m = kNone;
  double p50_m = kNone;  // quantiles of the distance to within 0.8 %
  double p95_m = kNone;
  double max_m = kNone;
  double start_mae_m = kNone;      // mean distance of the starts, over all trials whose start is finite
  double mean_iterations = kNone;  // also of those that failed at the limit
  double p50_iterations = kNone;
  double p99_iterations = kNone;
  double max_iterations = kNone;

  // Half of the 95 % interval of mae_m, by Student's t over the answered trials.
  double mae_half_interval_m() const {
    return answered < 2 ? kNone : student_quantile(answered - 1) * mae_standard_error_m;
  }
  double axis_mean_mae_m() const { return (axis_mae_m[0] + axis_mae_m[1] + axis_mae_m[2]) / 3.0; }

  static void fields(auto& self, auto&& field) {
    SweepSetting::fields(self.setting, field);
    TRILAT_EACH(asked, answered, statuses, mae_m, mae_standard_error_m, axis_mae_m)
    field("axis_mean_mae_m", self.axis_mean_mae_m());
    TRILAT_EACH(rmse_m, p50_m, p95_m, max_m, start_mae_m, mean_iterations, p50_iterations, p99_iterations,
                max_iterations)
  }
};

// Results of a threshold sweep. Everything in it is simulated.
struct SweepSummary {
  static constexpr StudyKind kKind = StudyKind::threshold_sweep;
  std::string study;
  std::string paper = name_of(PaperStudy::none);
  bool simulated = true;
  std::uint64_t seed = 0;
  std::uint64_t trials = 0;  // of each cell
  std::uint64_t max_iterations = 0;
  std::uint64_t skipped = 0;                 // combinations that contradict themselves or repeat another
  std::uint64_t thresholds = 1, ranges = 1;  // how many of each an interpretation has
  std::vector<SweepCell> cells;          // interpretation by interpretation, in each threshold by threshold
  std::vector<ClaimNumber> claims = {};  // of the paper, that the study bears on

  // Settings that are alike in all but threshold and range of errors.
  std::size_t interpretations() const { return cells.size() / (thresholds * ranges); }
  const SweepCell& cell(std::size_t interpretation, std::size_t threshold, std::size_t range) const {
    return cells.at((interpretation * thresholds + threshold) * ranges + range);
  }

  TRILAT_FIELDS(study, paper, simulated, seed, trials, max_iterations, skipped, thresholds, ranges, cells,
                claims)
  void check(const JsonObject& object) const {
    if (thresholds == 0 || ranges == 0 || cells.size() % (thresholds * ranges) != 0)
      object.refuse("cells", "must hold one cell for every interpretation, threshold and range");
  }
};

}  // namespace trilat
