// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "datasets/results/speed_file.h"

namespace trilat {

struct MeasureOptions {
  std::size_t rounds = 480;
  std::size_t problems = 512;
  double pause_s = 0.1;  // after every tenth of the rounds: a disturbance shall not last through all
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};
};

// A baseline is measured so often: how far its run as a whole is off would else be in every night's ratio.
inline constexpr int kBaselineSpeedRuns = 3;

// Several measurements of one machine and reference as one, their rounds in order.
SpeedFile joined_speed(const std::vector<SpeedFile>& runs);

// Times every solver on the same simulated problems (four sensors, 2.5 cm noise), one thread. In every round
// the solvers take turns in another order, each between two runs of the reference, and their ratio is taken
// of these neighbours, so that heat, clock rate and what else runs hit both alike. Times are the thread's own
// processor time: waiting for a processor is not counted. Interrupted when asked to stop.
SpeedFile measure_speed(const MeasureOptions& options);

}  // namespace trilat
