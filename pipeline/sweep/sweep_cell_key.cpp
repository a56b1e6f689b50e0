// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_cell_key.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/items/item_store.h"

namespace trilat {

std::string id_of_cell(const SweepPlan& plan, std::size_t cell) {
  const SweepCellPlace place = place_of(plan, cell);
  const SweepSummary::ErrorRange& range = plan.spec.ranges[place.range];
  return fmt::format("{}/C {}/{} to {} m", plan.readings[place.reading].text.id,
                     plan.spec.thresholds[place.threshold], range.low_m, range.high_m);
}

std::string key_of_cell(const SweepPlan& plan, std::size_t cell) {
  const SweepCellPlace place = place_of(plan, cell);
  const SweepInterpretation& reading = plan.readings[place.reading].text;
  const SweepSummary::ErrorRange& range = plan.spec.ranges[place.range];
  return key_of_item({{"kind", "cell of a threshold sweep"},
                      {"sensors_m", reading.sensors_m},
                      {"joint", reading.joint},
                      {"error_model", reading.error_model},
                      {"threshold_unit", reading.threshold_unit},
                      {"gradient", reading.gradient},
                      {"curvature", reading.curvature},
                      {"stop", reading.stop},
                      {"damping", reading.damping},
                      {"start", reading.start},
                      {"threshold", plan.spec.thresholds[place.threshold]},
                      {"low_m", range.low_m},
                      {"high_m", range.high_m},
                      {"seed", plan.spec.seed},
                      {"trials", plan.spec.trials},
                      {"max_iterations", plan.spec.max_iterations},
                      {"digits_trials", plan.spec.digits_trials}});
}

}  // namespace trilat
