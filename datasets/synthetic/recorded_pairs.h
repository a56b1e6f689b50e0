// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/synthetic/generated_person.h"

namespace trilat {

// Quantiles of the distance between the joints that two sensors see, of one group of joints: medians over
// participants.
struct PairQuantiles {
  std::string pair, activity, group;
  double q50_m = 0.0, q90_m = 0.0, q99_m = 0.0;

  TRILAT_FIELDS(pair, activity, group, q50_m, q90_m, q99_m)
};

// How two real sensors disagree on one person (datasets/synthetic/recorded_pairs.json), and what a twin of it
// looks like. `scripts/measure_tracker` writes that file.
struct RecordedPairs {
  struct Pair {
    std::string name;
    double degrees = 0.0;  // between both sensors, seen from the person, who faces the second
  };
  struct Activity {
    std::string name;
    trilat::Activity simulated;
    double duration_s = 0.0;
  };
  struct Set {
    std::string name;  // "fitted": the tracker was measured on these participants; "judged": on others
    std::uint64_t participants = 0;
    std::vector<PairQuantiles> rows;
  };
  std::string source;
  double distance_m = 0.0, height_m = 0.0;  // of the sensors
  std::vector<Pair> pairs;
  std::vector<Activity> activities;
  std::vector<Set> sets;
};

const RecordedPairs& recorded_pairs();

}  // namespace trilat
