// SPDX-License-Identifier: MIT
#include "pipeline/budget_spec.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "datasets/base/json_ranges.h"

namespace trilat {

BudgetSpec parse_budget(const Json& json, const std::string& place, const std::filesystem::path& folder,
                        const SimulationSpec& fallback) {
  JsonObject object(json, place, "");
  BudgetSpec spec;
  spec.simulation = fallback;
  if (const std::string path = object.text("simulation", ""); !path.empty())
    spec.simulation = read_simulation(folder / path);
  if (!spec.simulation.body_tracker)
    object.refuse("simulation", "has no \"body_tracker\", whose errors a budget takes apart");
  spec.simulation.seed = object.count("seed", spec.simulation.seed);
  spec.simulation.participants =
      count_within(object, "participants", spec.simulation.participants, 1, 10'000);
  spec.calibration_sigma_m = number_within(object, "calibration_sigma_m", spec.calibration_sigma_m, 0.0, 1.0);
  spec.calibration_sigma_deg =
      number_within(object, "calibration_sigma_deg", spec.calibration_sigma_deg, 0.0, 45.0);
  // what is left is a study of accuracy
  Json rest = json;
  for (const char* key :
       {"simulation", "seed", "participants", "calibration_sigma_m", "calibration_sigma_deg"})
    rest.erase(key);
  rest["kind"] = "accuracy";
  spec.study = parse_study(rest, place, folder);
  if (!spec.study.conditions.empty())  // nobody looks at the others
    std::erase_if(spec.simulation.activities, [&](const ActivitySpec& activity) {
      const std::string& name = activity_names()[static_cast<std::size_t>(activity.activity)];
      return std::find(spec.study.conditions.begin(), spec.study.conditions.end(), name) ==
             spec.study.conditions.end();
    });
  if (!spec.simulation.recorded && spec.simulation.activities.empty())
    object.refuse("conditions", "names no activity of the simulation");
  return spec;
}

}  // namespace trilat
