// SPDX-License-Identifier: MIT
#include "pipeline/budget/budget_study.h"

#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"
#include "datasets/base/units.h"
#include "datasets/results/results_file.h"
#include "datasets/results/studies/budget_summary.h"
#include "datasets/synthetic/error_sources.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/methods/method.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/simulate/campaign_study.h"
#include "pipeline/simulate/simulate_take.h"

namespace trilat {
namespace {

void check_known(JsonObject& object, const std::string& key, const std::vector<std::string>& asked,
                 const std::vector<std::string>& known, const std::string& what) {
  for (const std::string& name : asked)
    if (std::ranges::find(known, name) == known.end())
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
  const std::string path = object.text("simulation", "");
  WatchedFiles document;
  if (!path.empty()) {
    document.add(folder / path);
    spec.simulation = read_simulation(folder / path);
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
      return std::ranges::find(spec.study.conditions, name) == spec.study.conditions.end();
    });
  return spec;
}

namespace {

constexpr double kSimulating = 0.5;  // share of the time

// Evaluates with sensors that are not quite where they are said to be.
void perturb(const BudgetSpec& spec, const std::filesystem::path& folder, Campaign& campaign) {
  const std::filesystem::path path = folder / "perturbed.json";
  write_calibration(path, perturbed(read_calibration(folder / "calibration.json"), spec.calibration_sigma_m,
                                    spec.calibration_sigma_deg * kRadPerDegree, spec.simulation.seed));
  for (Take& take : campaign.takes) take.calibration = path;
}

ResultsSummary evaluate_source(const BudgetSpec& spec, ErrorSource source,
                               const std::filesystem::path& folder, const Watch& watch) {
  Campaign campaign = simulate_campaign(with_only(spec.simulation, source), folder / "campaign",
                                        {watch.stop_requested, share_of(watch.progress, 0.0, kSimulating)});
  if (source == ErrorSource::calibration || source == ErrorSource::all)
    perturb(spec, folder / "campaign", campaign);
  return execute_study(spec.study, campaign, folder / "results",
                       {.stop_requested = watch.stop_requested,
                        .progress = share_of(watch.progress, kSimulating, 1.0 - kSimulating)});
}

std::string failure_of(const ResultsSummary& summary) {
  for (const TakeNote& note : summary.notes)
    if (note.failed) return note.place + ": " + note.text;
  return "no reason is given";
}

// The rows of one source alone.
Json measure_source(const BudgetSpec& spec, ErrorSource source, const std::filesystem::path& work,
                    const Watch& watch) {
  const ResultsSummary summary = evaluate_source(spec, source, work, watch);
  if (summary.takes_failed > 0)
    throw InputError(spec.simulation.name, "has a take that cannot be evaluated with the error \"" +
                                               name_of(source) + "\" alone: " + failure_of(summary));
  spec.inputs.check();
  Json rows = Json::array();
  for (const SummaryCell& cell : summary.cells)
    if (cell.group != kAverageGroup)
      rows.push_back(json_of(BudgetRow{name_of(source), cell.method, cell.condition, cell.group,
                                       cell.alignment, cell.answered, cell.rmse_m, cell.mae_m}));
  std::filesystem::remove_all(work);
  return rows;
}

// The settings that decide the rows of every source of error.
Json settings_json(const BudgetSpec& spec) {
  return {{"study", resolved_json(spec.study)},
          {"campaign", spec.simulation.name},
          {"seed", spec.simulation.seed},
          {"participants", spec.simulation.participants},
          {"calibration_sigma_m", spec.calibration_sigma_m},
          {"calibration_sigma_deg", spec.calibration_sigma_deg},
          {"sha256", spec.sha256}};
}

Json manifest_of_settings(const Json& settings) {
  Json more{{"campaign", settings.at("campaign")}, {"simulated", true}};
  for (const char* key : {"seed", "participants", "calibration_sigma_m", "calibration_sigma_deg"})
    more[key] = settings.at(key);
  return manifest_of(settings.at("study"), more);
}

BudgetSummary summary_of(const BudgetSpec& spec) {
  BudgetSummary budget;
  budget.study = spec.study.name;
  budget.campaign = spec.simulation.name;
  budget.seed = spec.simulation.seed;
  budget.participants = spec.simulation.participants;
  budget.calibration_sigma_m = spec.calibration_sigma_m;
  budget.calibration_sigma_rad = spec.calibration_sigma_deg * kRadPerDegree;
  return budget;
}

void add_source(ErrorSource source, const Outcome& outcome, BudgetSummary& budget) {
  budget.sources.push_back(name_of(source));
  budget.descriptions.push_back(description_of(source));
  for (const Json& row : outcome.json)
    budget.rows.push_back(read_as<BudgetRow>(JsonObject(row, outcome.place(), "")));
}

}  // namespace

Study budget_study(const BudgetSpec& spec) {
  const auto shared = std::make_shared<const BudgetSpec>(spec);
  const Json settings = settings_json(spec);
  Study study{.kind = name_of(StudyKind::error_budget),
              .settings = settings,
              .write_beside =
                  [shared](const std::filesystem::path& folder) {
                    write_declared_parameters(folder, simulation_parameters(shared->simulation));
                  },
              .reduce =
                  [shared](const Outcomes& outcomes, const std::filesystem::path& folder, const Watch&) {
                    BudgetSummary budget = summary_of(*shared);
                    for (const ErrorSource source : error_sources())
                      add_source(source, outcomes.at(name_of(source)), budget);
                    write_results(folder, budget);
                  },
              .manifest = [settings] { return manifest_of_settings(settings); }};
  for (const ErrorSource source : error_sources())
    study.items.push_back(
        {name_of(source), 1.0, [shared, source](const std::filesystem::path& into, const Watch& watch) {
           return measure_source(*shared, source, into / "work", watch);
         }});
  return study;
}

}  // namespace trilat
