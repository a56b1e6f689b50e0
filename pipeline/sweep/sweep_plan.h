// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "evaluators/solvers/nonlinear.h"
#include "pipeline/sweep/sweep_spec.h"
#include "pipeline/sweep/sweep_summary.h"

namespace trilat {

// One interpretation, ready to be computed.
struct SweepReading {
  SweepInterpretation text;
  RangeTrialModel trials;    // all but the range of errors
  NonlinearOptions options;  // all but the threshold
  SweepStart start = SweepStart::linear;
  double unit_m2 = 1.0;  // of C
  SensorPlane plane;     // of the rig
  // The sensors' mean goes along as the problem's hint, to choose between mirror images.
  bool has_hint = false;
};

struct SweepPlan {
  SweepSpec spec;
  std::vector<SweepReading> readings;
  std::uint64_t skipped = 0;  // combinations that contradict themselves or repeat another

  std::size_t cells() const { return readings.size() * spec.thresholds.size() * spec.ranges.size(); }
};

// Cells are numbered reading by reading, in each threshold by threshold.
struct SweepCellPlace {
  std::size_t reading = 0, threshold = 0, range = 0;
};
SweepCellPlace place_of(const SweepPlan& plan, std::size_t cell);
// The cell with its place filled in.
SweepCell with_place(const SweepPlan& plan, SweepCell cell, std::size_t number);

// The trials and the solver of one cell.
RangeTrialModel trials_of(const SweepPlan& plan, const SweepCellPlace& place);
NonlinearOptions options_of(const SweepPlan& plan, const SweepCellPlace& place);

// Every combination of the choices that makes sense. Skipped: what contradiction_in() names; a linear start
// for a rig that linear trilateration has no answer for; the rule step in a second unit, as it uses no C.
// InputError at `place` when nothing is left, or it is more than can be counted or kept.
SweepPlan make_sweep_plan(const SweepSpec& spec, const std::string& place);

}  // namespace trilat
