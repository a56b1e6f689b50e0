// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/claims.h"
#include "datasets/results/results_file.h"
#include "evaluators/metrics/student.h"

namespace trilat {

// One reading of what the paper leaves open, each choice in the words of the study.
struct SweepInterpretation {
  std::string id;                                  // the choices below, joined by '/'; unique
  std::string rig;                                 // its name
  std::vector<std::array<double, 3>> sensors_m;    // world
  std::string joint;                               // centre, volume
  std::string error_model;                         // range_signed, displacement, gaussian
  std::string threshold_unit;                      // cm2, m2
  std::string gradient, curvature, stop, damping;  // as of the method `nonlinear`
  std::string start;                               // linear, squared_ranges

  TRILAT_FIELDS(id, rig, sensors_m, joint, error_model, threshold_unit, gradient, curvature, stop, damping,
                start)
};

// One interpretation at one threshold and one range of errors. NaN where nothing answered. Errors are
// distances to the true joint, over the answered trials; the iterations are over all trials.
struct SweepCell {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::size_t interpretation = 0;
  std::size_t threshold = 0;
  std::size_t range = 0;
  std::uint64_t asked = 0;                        // trials done; fewer than the study's when interrupted
  std::uint64_t answered = 0;                     // of those, with a usable estimate
  std::map<std::string, std::uint64_t> statuses;  // sums to asked
  double mae_m = kNone;                           // mean Euclidean distance
  double mae_standard_error_m = kNone;            // standard deviation / sqrt(answered)
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
    TRILAT_EACH(interpretation, threshold, range, asked, answered, statuses, mae_m, mae_standard_error_m,
                axis_mae_m)
    field("axis_mean_mae_m", self.axis_mean_mae_m());
    TRILAT_EACH(rmse_m, p50_m, p95_m, max_m, start_mae_m, mean_iterations, p50_iterations, p99_iterations,
                max_iterations)
  }
};

// Results of a threshold sweep. Everything in it is simulated.
struct SweepSummary {
  static constexpr StudyKind kKind = StudyKind::threshold_sweep;
  struct ErrorRange {
    double low_m = 0.0, high_m = 0.0;
    TRILAT_FIELDS(low_m, high_m)
  };
  std::string study;
  bool simulated = true;
  std::uint64_t seed = 0;
  std::uint64_t trials = 0;  // asked of each cell
  std::uint64_t max_iterations = 0;
  std::uint64_t skipped = 0;       // combinations that contradict themselves or repeat another
  std::vector<double> thresholds;  // C as in the study, in each interpretation's unit
  std::vector<ErrorRange> ranges;
  std::vector<SweepInterpretation> interpretations;
  std::vector<SweepCell> cells;          // interpretation by interpretation, in each threshold by threshold
  std::vector<ClaimNumber> claims = {};  // of the paper, that the study bears on

  const SweepCell& cell(std::size_t interpretation, std::size_t threshold, std::size_t range) const {
    return cells.at((interpretation * thresholds.size() + threshold) * ranges.size() + range);
  }

  TRILAT_FIELDS(study, simulated, seed, trials, max_iterations, skipped, thresholds, ranges, interpretations,
                cells, claims)
  void check(const JsonObject& object) const;
};

// Whether the last threshold but one is a compromise in a reading, at every error range: the last one takes
// twice its steps, and the first one errs by a tenth more. False for fewer than three thresholds.
bool is_compromise(const SweepSummary& summary, std::size_t reading);

}  // namespace trilat
