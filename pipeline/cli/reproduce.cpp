// SPDX-License-Identifier: MIT
// `trilat reproduce`.
#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/calibration_study/execute_calibration.h"
#include "pipeline/cli/embedded_studies.h"
#include "pipeline/cli/part_progress.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/simulate_take.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/execute.h"
#include "pipeline/sweep/execute_sweep.h"
#include "reports/render.h"
#include "reports/sweep_tables.h"
#include "reports/write_report.h"

namespace trilat {
namespace {

constexpr std::uint64_t kQuickParticipants = 4;
constexpr std::uint64_t kQuickSearchTrials = 300;
constexpr std::uint64_t kQuickUnits = 4, kQuickFrames = 3, kQuickNearSamples = 25, kQuickRuns = 6;
constexpr std::uint64_t kAllTrials = std::numeric_limits<std::uint64_t>::max();

SimulationSpec campaign_spec(const ReproduceArguments& arguments) {
  const Json json = parse_json(embedded::paper_campaign_json, "pipeline/studies/paper_campaign.json");
  SimulationSpec spec = parse_simulation(json, "pipeline/studies/paper_campaign.json", {});
  spec.seed = arguments.seed;
  if (arguments.scale == "quick") spec.participants = kQuickParticipants;
  return spec;
}

StudySpec table3_study() {
  return parse_study(parse_json(embedded::table3_json, "pipeline/studies/table3.json"),
                     "pipeline/studies/table3.json", {});
}

SweepPlan sweep_plan(const char* text, const std::string& place, const ReproduceArguments& arguments,
                     std::uint64_t quick_trials) {
  SweepSpec spec = parse_sweep(parse_json(text, place), place);
  spec.seed = arguments.seed;
  if (arguments.scale == "quick") spec.trials = std::min(spec.trials, quick_trials);
  return make_sweep_plan(spec, place);
}

SweepSummary sweep_into(const std::filesystem::path& folder, const SweepPlan& plan,
                        const ReproduceArguments& arguments) {
  Progress progress("sweeping"), timing("timing");
  const SweepOutcome outcome =
      execute_sweep(plan, folder,
                    {arguments.threads, stop_requested, [&](double s) { progress.set(s); },
                     [&](double s) { timing.set(s); }});
  if (outcome.summary.interrupted) throw Interrupted();
  return outcome.summary;
}

void calibration_into(const std::filesystem::path& folder, const ReproduceArguments& arguments) {
  const std::string place = "pipeline/studies/calibration.json";
  CalibrationSpec spec = parse_calibration_spec(parse_json(embedded::calibration_json, place), place);
  spec.seed = arguments.seed;
  if (arguments.scale == "quick") {
    spec.units = std::min(spec.units, kQuickUnits);
    spec.frames = std::min(spec.frames, kQuickFrames);
    spec.near_samples = std::min(spec.near_samples, kQuickNearSamples);
    spec.runs = std::min(spec.runs, kQuickRuns);
  }
  PartProgress progress;
  const CalibrationSummary summary = execute_calibration(
      spec, folder, {arguments.threads, stop_requested, [&](const std::string& part, double share) {
                       progress.set(part, share);
                     }});
  if (summary.interrupted) throw Interrupted();
}

// The folder is ours to fill when it is new, empty or an earlier reproduction.
void check_output(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  if (!fs::exists(folder) || (fs::is_directory(folder) && fs::is_empty(folder)) ||
      fs::exists(folder / "campaign"))
    return;
  throw InputError(folder.string(),
                   "exists and is not an earlier reproduction; choose another name or remove it");
}

void print_json(const std::filesystem::path& folder, const ResultsSummary& summary) {
  const Json json{{"campaign", (folder / "campaign").string()},
                  {"results",
                   {(folder / "table1").string(), (folder / "table1_search").string(),
                    (folder / "calibration").string(), (folder / "table3").string()}},
                  {"report", (folder / "report" / "report.md").string()},
                  {"takes_failed", summary.takes_failed},
                  {"cross_check_passed", summary.cross_check && summary.cross_check->passed()}};
  fmt::print("{}\n", json_text(json, 2));
}

// Tables I and III, the calibration and the search's answer; the rest is in the report.
void print_tables(const std::filesystem::path& folder, const ReportFiles& report, const SweepSummary& search,
                  const ResultsSummary& summary) {
  for (const char* id : {"table1", "calibration_wand", "calibration_rigs", "table3"})
    for (const Table& table : report.tables)
      if (table.id == id) fmt::print("{}\n", markdown_of(table));
  for (const std::string& sentence : search_sentences(search)) fmt::print("{}\n", sentence);
  fmt::print("\ncross-check with Ceres: worst difference {:.3g} m on {} samples\n",
             summary.cross_check->worst_m, summary.cross_check->samples);
  fmt::print("report:   {}\nresults:  {}\ncampaign: {}\n", (folder / "report" / "report.md").string(),
             folder.string(), (folder / "campaign").string());
}

}  // namespace

int reproduce(const ReproduceArguments& arguments) {
  const std::filesystem::path folder = arguments.output;
  check_output(folder);
  const SimulationSpec spec = campaign_spec(arguments);
  fmt::print(stderr, "1/6 simulating {} participants ({} scale, seed {})\n", spec.participants,
             arguments.scale, spec.seed);
  Campaign campaign;
  {
    Progress progress("simulating");
    campaign =
        simulate_campaign(spec, folder / "campaign", stop_requested, [&](double s) { progress.set(s); });
  }
  fmt::print(stderr, "2/6 Table III: every method on every take, cross-checked with Ceres\n");
  ResultsSummary summary;
  {
    Progress progress("evaluating");
    summary = execute_study(table3_study(), campaign, folder / "table3",
                            {arguments.threads, true, stop_requested, [&](double s) { progress.set(s); }});
  }
  fmt::print(stderr, "3/6 Table I: threshold against error and time, printed and corrected\n");
  const SweepPlan table1_plan =
      sweep_plan(embedded::table1_json, "pipeline/studies/table1.json", arguments, kAllTrials);
  sweep_into(folder / "table1", table1_plan, arguments);
  const SweepPlan search_plan = sweep_plan(
      embedded::table1_search_json, "pipeline/studies/table1_search.json", arguments, kQuickSearchTrials);
  fmt::print(stderr, "4/6 which of {} readings of the paper gives the printed Table I\n",
             search_plan.readings.size());
  const SweepSummary search = sweep_into(folder / "table1_search", search_plan, arguments);
  fmt::print(stderr, "5/6 calibration: one wand position, a flat wall, whole rigs, what it does to joints\n");
  calibration_into(folder / "calibration", arguments);
  fmt::print(stderr, "6/6 writing the report\n");
  const ReportFiles report =
      write_report({folder / "table1", folder / "table1_search", folder / "calibration", folder / "table3"},
                   folder / "report");
  const bool passed = summary.takes_failed == 0 && (!summary.cross_check || summary.cross_check->passed());
  if (arguments.json)
    print_json(folder, summary);
  else
    print_tables(folder, report, search, summary);
  return passed ? kDone : kItemsFailed;
}

}  // namespace trilat
