// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/results/results_file.h"

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

  // Key of the cell's numbers: condition "square, volume, range_signed, 0.05 to 0.15 m", group "C = 0.0001
  // cm2", method "corrected gradient, gauss_newton, stop objective, damping none, start linear".
  NumberKey key() const;

  static void fields(auto& self, auto&& f) {
    f("rig", self.rig, "joint", self.joint, "error_model", self.error_model, "threshold_unit",
      self.threshold_unit, "gradient", self.gradient, "curvature", self.curvature, "stop", self.stop,
      "damping", self.damping, "start", self.start, "threshold", self.threshold, "error_low_m",
      self.error_low_m, "error_high_m", self.error_high_m);
  }
};

// A cell of the sweep as summary.json lists it: its setting and the key of its numbers.
struct SweepCell : SweepSetting {
  static void fields(auto& self, auto&& f) {
    SweepSetting::fields(self, f);
    const NumberKey key = self.key();
    f.written("condition", key.condition);
    f.written("group", key.group);
    f.written("method", key.method);
  }
};

// Results of a threshold sweep. Everything in it is simulated. Its numbers are, by cell: the distance to the
// true joint (mean, rms, median, p95, max) and along the axes x, y and z (mean_abs), over the answered
// trials; the mean distance of the "start", over the finite ones; "iterations" (mean, median, p99, max) over
// all trials; what is answered, and by which status.
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
  std::vector<SweepCell> cells;  // interpretation by interpretation, in each threshold by threshold
  std::uint64_t rows = 0;
  Numbers numbers = {};

  // Settings that are alike in all but threshold and range of errors.
  std::size_t interpretations() const { return cells.size() / (thresholds * ranges); }
  std::size_t number_of(std::size_t interpretation, std::size_t threshold, std::size_t range) const {
    return (interpretation * thresholds + threshold) * ranges + range;
  }
  const SweepCell& cell(std::size_t interpretation, std::size_t threshold, std::size_t range) const {
    return cells.at(number_of(interpretation, threshold, range));
  }
  // A number of a cell: `what` is a measure and a statistic. NaN where nothing answered.
  double value(const SweepSetting& cell, const NumberKey& what) const {
    return numbers.value(cell.key().with(what));
  }

  static void fields(auto& self, auto&& f) {
    f("study", self.study, "paper", self.paper, "simulated", self.simulated, "seed", self.seed, "trials",
      self.trials, "max_iterations", self.max_iterations, "skipped", self.skipped, "thresholds",
      self.thresholds, "ranges", self.ranges, "cells", self.cells, "rows", self.rows);
  }
  void check(const JsonPlace& place) const {
    if (thresholds == 0 || ranges == 0 || cells.size() % (thresholds * ranges) != 0)
      place.at("cells").refuse("must hold one cell for every interpretation, threshold and range");
  }
};

// Measures and statistics of a cell.
inline const NumberKey kSweptError{.measure = "distance", .statistic = "mean"};
inline const NumberKey kSweptSteps{.measure = "iterations", .statistic = "mean"};
inline const NumberKey kSweptAnswers{.measure = "answered", .statistic = "share"};
// Mean over the axes of the mean absolute errors along them, in metres.
inline double axis_mean_m(const SweepSummary& sweep, const SweepSetting& cell) {
  double sum_m = 0.0;
  for (const char* axis : kAxisNames) sum_m += sweep.value(cell, {.measure = axis, .statistic = "mean_abs"});
  return sum_m / kAxisNames.size();
}

}  // namespace trilat
