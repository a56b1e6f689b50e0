// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/results/results_file.h"

namespace trilat {

// How two sensors disagree on one group of joints: recorded, and simulated twins. Medians over participants.
struct TwinsRow {
  std::string set, pair, activity, group;
  double recorded_q50_m = 0.0, recorded_q90_m = 0.0, recorded_q99_m = 0.0;
  double simulated_q50_m = 0.0, simulated_q90_m = 0.0, simulated_q99_m = 0.0;

  TRILAT_FIELDS(set, pair, activity, group, recorded_q50_m, recorded_q90_m, recorded_q99_m, simulated_q50_m,
                simulated_q90_m, simulated_q99_m)
};

// summary.json of a study of kind "twins".
struct TwinsSummary {
  static constexpr StudyKind kKind = StudyKind::twins;
  std::string study, source;
  std::uint64_t seed = 0, participants = 0;  // simulated
  std::vector<TwinsRow> rows;

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(study, source)
    field("simulated", true);
    TRILAT_EACH(seed, participants, rows)
  }
};

}  // namespace trilat
