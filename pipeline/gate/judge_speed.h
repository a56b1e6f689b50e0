// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "datasets/results/speed_file.h"
#include "pipeline/gate/finding.h"
#include "pipeline/gate/gate_report.h"
#include "pipeline/gate/judge_cells.h"

namespace trilat {

// Changes of a solver's ratio to the reference that are smaller are not told: a build that only places its
// code elsewhere can do that much.
inline constexpr double kSmallestSpeed_percent = 6.0;

// While other programs keep more processors busy than this, they share caches and clock rates with the
// solvers, not with all alike: what is slower then is told and no alarm.
inline constexpr double kBusy = 0.3;
inline bool is_disturbed(const SpeedFile& speed) { return speed.others_busy > kBusy; }

struct SpeedJudgement {
  SpeedVerdict verdict;
  std::vector<GateFinding> findings;
};

// Measurements that must say so too before a slower solver is an alarm.
inline constexpr int kSpeedReruns = 2;

// Ratios of tonight against the baseline's, by their lower quartiles: a finding where they differ by more
// than the smallest effect, the interval leaves no change out, and chance by Holm over the solvers is at most
// half of limits.chance. What is slower is measured again by `measure_again`, kSpeedReruns times, and is an
// alarm only when all say so and none was disturbed; without a way to measure again it is told and no alarm.
// On another processor or with another reference nothing is judged.
SpeedJudgement judge_speed(const SpeedFile& now, const SpeedFile& before, const GateLimits& limits,
                           const std::function<SpeedFile()>& measure_again);

}  // namespace trilat
