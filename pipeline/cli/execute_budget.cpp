// SPDX-License-Identifier: MIT
#include "pipeline/cli/execute_budget.h"

#include <chrono>

#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/units.h"
#include "datasets/base/version.h"
#include "datasets/results/declared_parameters.h"
#include "datasets/synthetic/error_sources.h"
#include "pipeline/cli/simulate_take.h"
#include "pipeline/execute.h"
#include "pipeline/manifest.h"
#include "pipeline/results_folder.h"

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
                               const std::filesystem::path& folder, const BudgetOptions& options) {
  const std::string name = name_of(source);
  const auto tell = [&](double share) {
    if (options.progress) options.progress(name, share);
  };
  Campaign campaign =
      simulate_campaign(with_only(spec.simulation, source, spec.simulation.name), folder / "campaign",
                        options.stop_requested, [&](double share) { tell(kSimulating * share); });
  if (source == ErrorSource::calibration || source == ErrorSource::all)
    perturb(spec, folder / "campaign", campaign);
  return execute_study(
      spec.study, campaign, folder / "results",
      {options.threads, false, options.stop_requested,
       [&](double share) { tell(kSimulating + (1.0 - kSimulating) * share); }, options.memory_bytes});
}

void write_budget_manifest(const std::filesystem::path& folder, const BudgetSpec& spec) {
  const Json study = resolved_json(spec.study);
  const Json json{{"format", "trilat.manifest"},
                  {"version", 1},
                  {"program", kProgramVersion},
                  {"study", study},
                  {"study_sha256", hash_of_text(study.dump())},
                  {"campaign", spec.simulation.name},
                  {"simulated", true},
                  {"seed", spec.simulation.seed},
                  {"participants", spec.simulation.participants},
                  {"calibration_sigma_m", spec.calibration_sigma_m},
                  {"calibration_sigma_deg", spec.calibration_sigma_deg}};
  write_file(folder / "manifest.json", json_text(json, 1) + "\n");
}

std::string failure_of(const ResultsSummary& summary) {
  for (const TakeNote& note : summary.notes)
    if (note.failed) return note.place + ": " + note.text;
  return "no reason is given";
}

BudgetSummary execute_into(const BudgetSpec& spec, const std::filesystem::path& folder,
                           const BudgetOptions& options) {
  const std::filesystem::path work = folder / "work";
  BudgetSummary budget;
  budget.study = spec.study.name;
  budget.campaign = spec.simulation.name;
  budget.seed = spec.simulation.seed;
  budget.participants = spec.simulation.participants;
  budget.calibration_sigma_m = spec.calibration_sigma_m;
  budget.calibration_sigma_rad = spec.calibration_sigma_deg * kRadPerDegree;
  for (const ErrorSource source : error_sources()) {
    budget.sources.push_back(name_of(source));
    budget.descriptions.push_back(description_of(source));
    const ResultsSummary summary = evaluate_source(spec, source, work, options);
    if (summary.takes_failed > 0)
      throw InputError(spec.simulation.name, "has a take that cannot be evaluated with the error \"" +
                                                 name_of(source) + "\" alone: " + failure_of(summary));
    for (const SummaryCell& cell : summary.cells)
      if (cell.group != kAverageGroup)
        budget.rows.push_back({name_of(source), cell.method, cell.condition, cell.group, cell.alignment,
                               cell.answered, cell.rmse_m, cell.mae_m});
    std::filesystem::remove_all(work);
  }
  write_budget_manifest(folder, spec);
  write_budget_summary(folder, budget);
  write_declared_parameters(folder, declared_parameters(spec.simulation));
  return budget;
}

}  // namespace

BudgetSummary execute_budget(const BudgetSpec& spec, const std::filesystem::path& output,
                             const BudgetOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const ResultsFolder folder(output);
  BudgetSummary budget;
  on_threads(options.threads, [&](int threads) {
    budget = execute_into(spec, folder.partial(), options);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    write_run_record(folder.partial(), Json::object(), wall.count(), threads);
  });
  folder.put_in_place();
  return budget;
}

}  // namespace trilat
