// SPDX-License-Identifier: MIT
#include "pipeline/budget/budget_study.h"

#include <memory>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/units.h"
#include "datasets/results/results_file.h"
#include "datasets/results/studies/budget_summary.h"
#include "datasets/synthetic/error_sources.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/simulate/campaign_study.h"
#include "pipeline/simulate/simulate_take.h"

namespace trilat {
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
                               const std::filesystem::path& folder, std::uint64_t memory_bytes,
                               const Watch& watch) {
  Campaign campaign = simulate_campaign(with_only(spec.simulation, source), folder / "campaign",
                                        {watch.stop_requested, share_of(watch.progress, 0.0, kSimulating)});
  if (source == ErrorSource::calibration || source == ErrorSource::all)
    perturb(spec, folder / "campaign", campaign);
  ExecuteOptions options{.stop_requested = watch.stop_requested,
                         .progress = share_of(watch.progress, kSimulating, 1.0 - kSimulating)};
  options.memory_bytes = memory_bytes;
  return execute_study(spec.study, campaign, folder / "results", options);
}

std::string failure_of(const ResultsSummary& summary) {
  for (const TakeNote& note : summary.notes)
    if (note.failed) return note.place + ": " + note.text;
  return "no reason is given";
}

// The rows of one source alone.
Json measure_source(const BudgetSpec& spec, ErrorSource source, const std::filesystem::path& work,
                    std::uint64_t memory_bytes, const Watch& watch) {
  const ResultsSummary summary = evaluate_source(spec, source, work, memory_bytes, watch);
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

// What all parts of a budget share, and all that putting them together needs.
Json work_json(const BudgetSpec& spec) {
  return {{"study", resolved_json(spec.study)},
          {"campaign", spec.simulation.name},
          {"seed", spec.simulation.seed},
          {"participants", spec.simulation.participants},
          {"calibration_sigma_m", spec.calibration_sigma_m},
          {"calibration_sigma_deg", spec.calibration_sigma_deg},
          {"sha256", spec.sha256}};
}

Json manifest_of_work(const Json& work) {
  Json more{{"campaign", work.at("campaign")}, {"simulated", true}};
  for (const char* key : {"seed", "participants", "calibration_sigma_m", "calibration_sigma_deg"})
    more[key] = work.at(key);
  return manifest_of(work.at("study"), more);
}

BudgetSummary summary_of(const Json& json, const std::string& place) {
  JsonObject work(json, place, "/work");
  BudgetSummary budget;
  budget.study = work.object("study").text("name");
  budget.campaign = work.text("campaign");
  budget.seed = work.count("seed");
  budget.participants = work.count("participants");
  budget.calibration_sigma_m = work.number("calibration_sigma_m");
  budget.calibration_sigma_rad = work.number("calibration_sigma_deg") * kRadPerDegree;
  work.text("sha256");
  work.finish();
  return budget;
}

void add_source(ErrorSource source, const Outcome& outcome, BudgetSummary& budget) {
  budget.sources.push_back(name_of(source));
  budget.descriptions.push_back(description_of(source));
  for (const Json& row : outcome.json())
    budget.rows.push_back(read_as<BudgetRow>(JsonObject(row, outcome.place(), "")));
}

}  // namespace

Study budget_of_parts(const Json& work, const std::string& place) {
  const BudgetSummary head = summary_of(work, place);
  Study study{.kind = name_of(StudyKind::error_budget),
              .work = work,
              .reduce =
                  [head](const Outcomes& outcomes, const std::filesystem::path& results, const Watch&) {
                    BudgetSummary budget = head;
                    for (const ErrorSource source : error_sources())
                      add_source(source, outcomes.at(name_of(source)), budget);
                    write_budget_summary(results, budget);
                  },
              .manifest = [work](const Outcomes&) { return manifest_of_work(work); }};
  for (const ErrorSource source : error_sources()) study.items.push_back({name_of(source), 1.0, {}});
  return study;
}

Study budget_study(const BudgetSpec& spec, std::uint64_t memory_bytes) {
  Study study = budget_of_parts(work_json(spec), "error budget");
  study.write_beside = [parameters =
                            declared_parameters(spec.simulation)](const std::filesystem::path& folder) {
    write_declared_parameters(folder, parameters);
  };
  const auto shared = std::make_shared<const BudgetSpec>(spec);
  for (std::size_t i = 0; i < study.items.size(); ++i)
    study.items[i].compute = [=, source = error_sources()[i]](const std::filesystem::path& into,
                                                              const Watch& watch) {
      return measure_source(*shared, source, into / "work", memory_bytes, watch);
    };
  return study;
}

}  // namespace trilat
