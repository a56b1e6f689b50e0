// SPDX-License-Identifier: MIT
#include "pipeline/budget/budget_spec.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"
#include "pipeline/accuracy/methods/method.h"
#include "pipeline/accuracy/take/plan.h"

namespace trilat {
namespace {

void check_known(JsonObject& object, const std::string& key, const std::vector<std::string>& asked,
                 const std::vector<std::string>& known, const std::string& what) {
  for (const std::string& name : asked)
    if (std::find(known.begin(), known.end(), name) == known.end())
      object.refuse(key, fmt::format("has \"{}\", which the simulation does not have; its {} are \"{}\"",
                                     name, what, fmt::join(known, "\", \"")));
}

// A study that does not fit the simulation is refused before anything is simulated.
void check_fits(JsonObject& object, const StudySpec& study, const SimulationSpec& simulation) {
  std::vector<std::string> activities, rig;
  if (simulation.recorded) activities.push_back(simulation.recorded->activity);
  for (const ActivitySpec& activity : simulation.activities)
    activities.push_back(activity_names()[static_cast<std::size_t>(activity.activity)]);
  for (const SensorPose& pose : rig_poses(simulation.rig, Eigen::Vector3d::Zero())) rig.push_back(pose.name);
  check_known(object, "conditions", study.conditions, activities, "activities");
  check_known(object, "sensors", study.sensors, rig, "sensors");
  reference_of(study, resolve_methods(study, study.sensors.empty() ? rig : study.sensors));
}

// Of all that a budget is read from. A file that is not there is somebody else's error.
std::string hash_of_inputs(const Json& json, const std::filesystem::path& simulation,
                           const SimulationSpec& spec) {
  std::vector<std::filesystem::path> files{simulation};
  if (spec.recorded) files.insert(files.end(), {spec.recorded->mocap, spec.recorded->mapping});
  if (!spec.body_tracker_file.empty()) files.push_back(spec.body_tracker_file);
  std::string text = json_text(json, -1);
  for (const std::filesystem::path& file : files)
    if (std::filesystem::is_regular_file(file)) text += hash_of_file(file);
  return hash_of_text(text);
}

}  // namespace

BudgetSpec parse_budget(const Json& json, const std::string& place, const std::filesystem::path& folder,
                        const SimulationSpec& fallback, OutsidePaths outside) {
  JsonObject object(json, place, "");
  object.choice("kind", {"error_budget"});
  BudgetSpec spec;
  spec.study = read_accuracy_settings(object, folder);
  if (!spec.study.campaign.empty())
    object.refuse("campaign",
                  "is of no use: an error budget simulates its own campaigns; name their simulation.json as "
                  "\"simulation\"");
  spec.simulation = fallback;
  const std::string path = object.text("simulation", "");
  WatchedFiles document;
  if (!path.empty()) {
    document.add(folder / path);
    spec.simulation = read_simulation(folder / path, outside);
  }
  if (spec.simulation.recorded)
    spec.inputs = WatchedFiles({spec.simulation.recorded->mocap, spec.simulation.recorded->mapping});
  spec.sha256 = hash_of_inputs(json, path.empty() ? path : (folder / path).string(), spec.simulation);
  document.check();
  setting(object, "seed", spec.simulation.seed, "instead of the simulation's");
  if (spec.simulation.recorded && object.has("participants"))
    object.refuse("participants", "is of no use: the simulation watches a recorded take, which has one");
  setting(object, "participants", spec.simulation.participants, {1, 10'000}, "instead of the simulation's");
  setting(object, "calibration_sigma_m", spec.calibration_sigma_m, {0.0, 1.0},
          "error of a sensor's position, an axis");
  setting(object, "calibration_sigma_deg", spec.calibration_sigma_deg, {0.0, 45.0}, "and of its rotation");
  object.about({{"simulation", "simulation.json, relative to this file; without it the paper's campaign"}});
  object.finish();
  check_fits(object, spec.study, spec.simulation);
  if (!spec.study.conditions.empty())  // nobody looks at the others
    std::erase_if(spec.simulation.activities, [&](const ActivitySpec& activity) {
      const std::string& name = activity_names()[static_cast<std::size_t>(activity.activity)];
      return std::find(spec.study.conditions.begin(), spec.study.conditions.end(), name) ==
             spec.study.conditions.end();
    });
  return spec;
}

}  // namespace trilat
