// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "datasets/base/philox.h"
#include "datasets/results/speed_file.h"
#include "pipeline/gate/measure_speed.h"

namespace trilat {

inline const std::vector<std::string> kSolvers{"linear", "geometric", "nonlinear", "nonlinear, batch",
                                               "newton"};
// How far runs as a whole were off each other, in eight runs on two cores with ten jobs on them; rounded up.
inline constexpr std::array<double, 5> kRunSigma{0.003, 0.010, 0.003, 0.026, 0.004};

// One simulated measurement with noise as measured in these runs: most rounds within 1 %, a fifth off by 8 %
// either way, and in up to half of the time something on the same core makes a solver a tenth slower.
inline SpeedFile measured_speed_night(std::uint64_t number, double slower = 0.0, double run_share = 1.0) {
  SpeedFile speed{"a processor", "a reference", 512, 450.0, 0.0, {}};
  for (std::size_t s = 0; s < kSolvers.size(); ++s) {
    const RandomStream random{7, Purpose::test, number * 16 + s};
    std::uint32_t draw = 0;
    SolverSpeed solver{kSolvers[s], {}, 1000.0};
    const double run_sigma = run_share * kRunSigma[s];
    const double level = std::exp(run_sigma * random.normal(draw++)) * (s == 2 ? 1.0 + slower : 1.0);
    const double disturbed = 0.5 * random.uniform(draw++);
    bool busy = false;
    for (int round = 0; round < 480; ++round) {
      if (round % 24 == 0) busy = random.uniform(draw++) < disturbed;
      const double spread = random.uniform(draw++) < 0.2 ? 0.08 : 0.01;
      solver.ratios.push_back(level * std::exp(spread * random.normal(draw++)) * (busy ? 1.1 : 1.0));
    }
    speed.solvers.push_back(solver);
  }
  return speed;
}

// A baseline's, as accepting measures it.
inline SpeedFile measured_speed_baseline(std::uint64_t number) {
  std::vector<SpeedFile> runs;
  for (int run = 0; run < kBaselineSpeedRuns; ++run)
    runs.push_back(measured_speed_night(number + 10'000'000ULL * static_cast<std::uint64_t>(run + 1)));
  return joined_speed(runs);
}

}  // namespace trilat
