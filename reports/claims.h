// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/results/calibration_summary.h"
#include "datasets/results/recording_summary.h"
#include "datasets/results/stage_timings.h"
#include "datasets/results/summary.h"
#include "datasets/results/sweep_summary.h"
#include "reports/table.h"

namespace trilat {

// The results that the paper's claims are held against, as far as there are any.
struct ClaimEvidence {
  std::optional<ResultsSummary> walking;      // Table III
  std::optional<ResultsSummary> occluded;     // Table II
  std::vector<ResultsSummary> sensor_counts;  // methods named "nonlinear, N sensors"
  std::optional<SweepSummary> sweep;          // Table I
  std::optional<CalibrationSummary> calibration;
  std::optional<RecordingSummary> recording;  // Table IV
  std::optional<StageTimings> stages;

  // Takes a study in when it is one of these; the first of its kind counts.
  void add(const ResultsSummary& summary);
  // Whether there is anything of Tables II or III, so that a list of claims says something.
  bool is_of_the_paper() const { return walking.has_value() || occluded.has_value(); }
};

// Whether anything here comes from simulated sensors.
bool any_simulated(const ClaimEvidence& evidence);

// Each claim of the paper: its number, ours with its interval, a verdict (holds, does not hold, undecided,
// cannot be tested here, contradicts itself) and the reason. Verdicts from simulated sensors say so.
Table claims_table(const ClaimEvidence& evidence);

}  // namespace trilat
