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
#include "datasets/results/results_file.h"
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
  ExecuteOptions part{.threads = options.threads, .stop_requested = options.stop_requested};
  part.progress = [&](double share) { tell(kSimulating + (1.0 - kSimulating) * share); };
  part.memory_bytes = options.memory_bytes;
  return execute_study(spec.study, campaign, folder / "results", part);
}

std::string failure_of(const ResultsSummary& summary) {
  for (const TakeNote& note : summary.notes)
    if (note.failed) return note.place + ": " + note.text;
  return "no reason is given";
}

// The rows of one source alone.
Json measure_source(const BudgetSpec& spec, ErrorSource source, const std::filesystem::path& work,
                    const BudgetOptions& options) {
  const ResultsSummary summary = evaluate_source(spec, source, work, options);
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

void write_budget_manifest(const std::filesystem::path& folder, const Json& work) {
  Json json{{"format", "trilat.manifest"},
            {"version", 1},
            {"program", kProgramVersion},
            {"study", work.at("study")},
            {"study_sha256", hash_of_text(work.at("study").dump())},
            {"campaign", work.at("campaign")},
            {"simulated", true}};
  for (const char* key : {"seed", "participants", "calibration_sigma_m", "calibration_sigma_deg"})
    json[key] = work.at(key);
  write_file(folder / "manifest.json", json_text(json, 1) + "\n");
}

std::vector<PartItem> list_of_items() {
  std::vector<PartItem> items;
  for (const ErrorSource source : error_sources()) items.push_back({name_of(source)});
  return items;
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

void add_source(ErrorSource source, const Json& rows, BudgetSummary& budget) {
  budget.sources.push_back(name_of(source));
  budget.descriptions.push_back(description_of(source));
  for (const Json& row : rows) budget.rows.push_back(read_budget_row(JsonObject(row, name_of(source), "")));
}

// `budget`: without its rows; `compute` makes those of a source that is not known.
BudgetSummary put_together(BudgetSummary budget, const Json& work, StudyItems& items,
                           const std::filesystem::path& folder,
                           const std::vector<DeclaredParameter>& parameters,
                           const std::function<Json(ErrorSource)>& compute) {
  for (const ErrorSource source : error_sources())
    if (const auto rows = items.outcome(name_of(source), [&] { return compute(source); }))
      add_source(source, *rows, budget);
  if (items.whole()) {
    write_budget_manifest(folder, work);
    write_budget_summary(folder, budget);
  }
  write_declared_parameters(folder, parameters);
  items.finish(folder, key_of_item(work));
  return budget;
}

}  // namespace

BudgetSummary execute_budget(const BudgetSpec& spec, const std::filesystem::path& output,
                             const BudgetOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const Json work = work_json(spec);
  const std::vector<PartItem> list = list_of_items();
  if (is_done_already(output, options.work, key_of_item(work), list, {"simulator.json"}, options.tally))
    return read_budget_summary(output);
  const ResultsFolder folder(output, options.fresh ? Kept{} : Kept{ItemJournal::kFile});
  BudgetSummary budget;
  on_threads(options.threads, [&](int threads) {
    StudyItems items(name_of(ResultsKind::error_budget), work, list, folder.partial(), options.work);
    budget = put_together(summary_of(work, output.string()), work, items, folder.partial(),
                          declared_parameters(spec.simulation), [&](ErrorSource source) {
                            return measure_source(spec, source, folder.partial() / "work", options);
                          });
    if (options.tally) *options.tally = items.tally();
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    write_run_record(folder.partial(), json_of(items.tally()), wall.count(), threads);
  });
  folder.put_in_place();
  return budget;
}

BudgetSummary merge_budget(const std::vector<FoundPart>& parts, const std::filesystem::path& output,
                           const BudgetOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const FoundPart& first = parts.front();
  const BudgetSummary head = summary_of(first.part.work, (first.folder / "part.json").string());
  StudyItems items(parts);
  const ResultsFolder folder(output);
  const BudgetSummary budget = put_together(head, first.part.work, items, folder.partial(),
                                            read_declared_parameters(first.folder), {});
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  write_run_record(folder.partial(), Json::object(), wall.count(), options.threads);
  folder.put_in_place();
  return budget;
}

}  // namespace trilat
