// SPDX-License-Identifier: MIT
#include "pipeline/budget_spec.h"

#include "datasets/base/json_ranges.h"

namespace trilat {

BudgetSpec parse_budget(const Json& json, const std::string& place, const std::filesystem::path& folder,
                        const SimulationSpec& fallback) {
  JsonObject object(json, place, "");
  object.choice("kind", {"error_budget"});
  BudgetSpec spec;
  spec.study = read_accuracy_settings(object, folder);
  if (!spec.study.campaign.empty())
    object.refuse("campaign",
                  "is of no use: an error budget simulates its own campaigns; name their simulation.json as "
                  "\"simulation\"");
  spec.simulation = fallback;
  if (const std::string path = object.text("simulation", ""); !path.empty())
    spec.simulation = read_simulation(folder / path);
  if (!spec.simulation.body_tracker)
    object.refuse("simulation", "has no \"body_tracker\", whose errors a budget takes apart");
  spec.simulation.seed = object.count("seed", spec.simulation.seed);
  if (spec.simulation.recorded && object.has("participants"))
    object.refuse("participants", "is of no use: the simulation watches a recorded take, which has one");
  spec.simulation.participants =
      count_within(object, "participants", spec.simulation.participants, 1, 10'000);
  spec.calibration_sigma_m = number_within(object, "calibration_sigma_m", spec.calibration_sigma_m, 0.0, 1.0);
  spec.calibration_sigma_deg =
      number_within(object, "calibration_sigma_deg", spec.calibration_sigma_deg, 0.0, 45.0);
  object.finish();
  return spec;
}

}  // namespace trilat
