// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_summary.h"

namespace trilat {

// Numbers of interpretations and lists that are read by their place.
void SweepSummary::check(const JsonObject& object) const {
  bool fits = cells.size() == interpretations.size() * thresholds.size() * ranges.size();
  for (std::size_t i = 0; fits && i < cells.size(); ++i)
    fits = cells[i].interpretation == i / ranges.size() / thresholds.size() &&
           cells[i].threshold == i / ranges.size() % thresholds.size() && cells[i].range == i % ranges.size();
  if (!fits)
    object.refuse("cells", "must hold one cell for every interpretation, threshold and range, in this order");
}

bool is_compromise(const SweepSummary& s, std::size_t reading) {
  constexpr double kMoreSteps = 2.0, kLessAccurate = 1.1;
  if (s.thresholds.size() < 3) return false;
  const std::size_t last = s.thresholds.size() - 1;
  for (std::size_t range = 0; range < s.ranges.size(); ++range) {
    const SweepCell &first = s.cell(reading, 0, range), &chosen = s.cell(reading, last - 1, range),
                    &smallest = s.cell(reading, last, range);
    if (!(smallest.mean_iterations >= kMoreSteps * chosen.mean_iterations) ||
        !(first.mae_m >= kLessAccurate * chosen.mae_m))
      return false;
  }
  return true;
}

}  // namespace trilat
