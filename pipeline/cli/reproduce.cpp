// SPDX-License-Identifier: MIT
// `trilat reproduce`.
#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/budget/budget_study.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/claims/judge_claims.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/embedded_studies.h"
#include "pipeline/cli/terminal/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/recording/recording_study.h"
#include "pipeline/sensitivity/sensitivity_study.h"
#include "pipeline/simulate/campaign_study.h"
#include "pipeline/sweep/sweep_study.h"
#include "pipeline/twins/twins_study.h"
#include "reports/write_report.h"

namespace trilat {
namespace {

constexpr std::uint64_t kQuickParticipants = 4, kQuickBudgetParticipants = 2;
constexpr int kStages = 12;
constexpr std::uint64_t kQuickSearchTrials = 300;
constexpr std::uint64_t kQuickUnits = 4, kQuickFrames = 3, kQuickNearSamples = 25, kQuickRuns = 6;
constexpr std::uint64_t kQuickRecordingFrames = 3000, kQuickRecordingRuns = 4;
constexpr std::uint64_t kQuickMapParticipants = 2, kQuickMapRows = 4, kQuickMapSteps = 4;
constexpr std::uint64_t kAllTrials = std::numeric_limits<std::uint64_t>::max();

SimulationSpec campaign_spec(const char* text, const std::string& place,
                             const ReproduceArguments& arguments) {
  SimulationSpec spec = parse_simulation(parse_json(text, place), place, {});
  spec.seed = arguments.seed;
  if (arguments.scale == "quick") spec.participants = std::min(spec.participants, kQuickParticipants);
  return spec;
}

SimulationSpec paper_campaign(const ReproduceArguments& arguments) {
  return campaign_spec(embedded::paper_campaign_json, "pipeline/studies/paper_campaign.json", arguments);
}

StudySpec study_from(const char* text, const std::string& place) {
  return parse_study(parse_json(text, place), place, {});
}

void begin_stage(int number, const std::string& text) {
  fmt::print(stderr, "{}/{} {}\n", number, kStages, text);
}

Campaign simulate_into(const std::filesystem::path& folder, const SimulationSpec& spec) {
  Progress progress("simulating");
  return simulate_campaign(spec, folder, {stop_requested, [&](double s) { progress.set(s); }});
}

// What an earlier reproduction left there and did not change since.
std::vector<std::filesystem::path> earlier(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) return {};
  return {folder};
}

ResultsSummary evaluate_into(const std::filesystem::path& folder, const StudySpec& study,
                             const Campaign& campaign, bool cross_check,
                             const ReproduceArguments& arguments) {
  Progress progress("evaluating");
  return execute_study(
      study, campaign, folder,
      {arguments.threads, cross_check, stop_requested, [&](double s) { progress.set(s); }, earlier(folder)});
}

void run_into(const std::filesystem::path& folder, const Study& study, const ReproduceArguments& arguments) {
  StageProgressBars progress;
  run_study(study, folder,
            {.threads = arguments.threads,
             .stop_requested = stop_requested,
             .progress = [&](const std::string& stage, double share) { progress.set(stage, share); },
             .reuse = earlier(folder)});
}

// Two rigs of eight sensors, of which the study takes two to eight. How many takes failed.
std::uint64_t sensors_into(const std::filesystem::path& folder, const ReproduceArguments& arguments) {
  const std::pair<const char*, const char*> rigs[] = {
      {"different_heights", embedded::sensors_different_heights_json},
      {"equal_heights", embedded::sensors_equal_heights_json}};
  std::uint64_t failed = 0;
  for (const auto& [name, text] : rigs) {
    const std::string rig = name;
    const std::string place = "pipeline/studies/sensors_" + rig + ".json";
    StudySpec study = study_from(embedded::sensors_json, "pipeline/studies/sensors.json");
    study.name += "_" + rig;
    const Campaign campaign =
        simulate_into(folder / ("campaign_" + rig), campaign_spec(text, place, arguments));
    failed += evaluate_into(folder / ("sensors_" + rig), study, campaign, false, arguments).takes_failed;
  }
  return failed;
}

void budget_into(const std::filesystem::path& folder, const ReproduceArguments& arguments) {
  const std::string place = "pipeline/studies/error_budget.json";
  BudgetSpec spec =
      parse_budget(parse_json(embedded::error_budget_json, place), place, {}, paper_campaign(arguments));
  spec.simulation.seed = arguments.seed;
  if (arguments.scale == "quick")
    spec.simulation.participants = std::min(spec.simulation.participants, kQuickBudgetParticipants);
  run_into(folder, budget_study(spec), arguments);
}

void sensitivity_into(const std::filesystem::path& folder, const ReproduceArguments& arguments) {
  const std::string place = "pipeline/studies/sensitivity.json";
  SensitivitySpec spec = parse_sensitivity(parse_json(embedded::sensitivity_json, place), place, {}, {});
  spec.head.seed = arguments.seed;
  if (arguments.scale == "quick") {
    spec.head.participants = kQuickMapParticipants;
    spec.head.rows = kQuickMapRows;
    spec.head.slices.resize(1);
    spec.head.slices[0].steps = kQuickMapSteps;
  }
  run_into(folder, sensitivity_study(spec), arguments);
}

SweepPlan sweep_plan(const char* text, const std::string& place, const ReproduceArguments& arguments,
                     std::uint64_t quick_trials) {
  SweepSpec spec = parse_sweep(parse_json(text, place), place);
  spec.seed = arguments.seed;
  if (arguments.scale == "quick") spec.trials = std::min(spec.trials, quick_trials);
  return make_sweep_plan(spec, place);
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
  run_into(folder, calibration_study(spec), arguments);
}

void recording_into(const std::filesystem::path& folder, const ReproduceArguments& arguments) {
  const std::string place = "pipeline/studies/table4.json";
  RecordingSpec spec = parse_recording_spec(parse_json(embedded::table4_json, place), place);
  spec.seed = arguments.seed;
  if (arguments.scale == "quick") {
    spec.frames = std::min(spec.frames, kQuickRecordingFrames);
    spec.runs = std::min(spec.runs, kQuickRecordingRuns);
  }
  run_into(folder, recording_study(spec), arguments);
}

void twins_into(const std::filesystem::path& folder, const ReproduceArguments& arguments) {
  TwinsSpec spec = parse_twins(parse_json(embedded::twins_json, "pipeline/studies/twins.json"), "twins.json");
  spec.seed = arguments.seed;
  run_into(folder, twins_study(spec), arguments);
}

// Every results folder, in the order of the report.
std::vector<std::filesystem::path> results_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> results;
  for (const char* name :
       {"sensitivity", "table3", "table2", "sensors_different_heights", "sensors_equal_heights",
        "error_budget", "table1", "table1_search", "calibration", "table4", "twins"})
    results.push_back(folder / name);
  return results;
}

// Everything that will be written, before hours of work.
void check_outputs(const ReproduceArguments& arguments) {
  const std::filesystem::path& folder = arguments.output;
  const auto check = [&](const std::filesystem::path& path, OutputKind kind) {
    check_output({path, kind, {}, arguments.force});
  };
  check(folder, OutputKind::reproduction);
  for (const char* campaign : {"campaign", "campaign_different_heights", "campaign_equal_heights"})
    check(folder / campaign, OutputKind::campaign);
  for (const std::filesystem::path& results : results_in(folder)) check(results, OutputKind::results);
  check(folder / "report", OutputKind::report);
}

ReportFiles report_into(const std::filesystem::path& folder) {
  Progress progress("writing the report");
  return write_report(
      results_in(folder), folder / "report",
      {.paper = judge_paper(results_in(folder)), .progress = [&](double s) { progress.set(s); }});
}

std::vector<std::string> texts_of(const std::vector<std::filesystem::path>& paths) {
  std::vector<std::string> texts;
  for (const auto& path : paths) texts.push_back(path.string());
  return texts;
}

void print_json(const std::filesystem::path& folder, const ResultsSummary& summary) {
  const Json json{{"campaign", (folder / "campaign").string()},
                  {"results", texts_of(results_in(folder))},
                  {"report", (folder / "report" / "report.md").string()},
                  {"page", (folder / "report" / "report.html").string()},
                  {"takes_failed", summary.takes_failed},
                  {"cross_check_passed", summary.cross_check && summary.cross_check->passed()}};
  fmt::print("{}\n", json_text(json, 2));
}

}  // namespace

int reproduce(const ReproduceArguments& arguments) {
  const std::filesystem::path folder = arguments.output;
  check_outputs(arguments);
  const SimulationSpec spec = paper_campaign(arguments);
  begin_stage(1, fmt::format("simulating {} participants ({} scale, seed {})", spec.participants,
                             arguments.scale, spec.seed));
  const Campaign campaign = simulate_into(folder / "campaign", spec);
  begin_stage(2, "Table III: every method on every take, cross-checked with Ceres");
  const ResultsSummary table3 =
      evaluate_into(folder / "table3", study_from(embedded::table3_json, "pipeline/studies/table3.json"),
                    campaign, true, arguments);
  begin_stage(3, "Table II: with and without occlusion compensation, printed and corrected");
  const ResultsSummary table2 =
      evaluate_into(folder / "table2", study_from(embedded::table2_json, "pipeline/studies/table2.json"),
                    campaign, false, arguments);
  begin_stage(4, "two to eight sensors, at different heights and at one");
  const std::uint64_t sensors_failed = sensors_into(folder, arguments);
  begin_stage(5, "the error budget: every source of error alone");
  budget_into(folder / "error_budget", arguments);
  begin_stage(6, "Table I: threshold against error and time, printed and corrected");
  const SweepPlan table1_plan =
      sweep_plan(embedded::table1_json, "pipeline/studies/table1.json", arguments, kAllTrials);
  run_into(folder / "table1", sweep_study(table1_plan), arguments);
  const SweepPlan search_plan = sweep_plan(
      embedded::table1_search_json, "pipeline/studies/table1_search.json", arguments, kQuickSearchTrials);
  begin_stage(7, fmt::format("which of {} readings of the paper gives the printed Table I",
                             search_plan.readings.size()));
  run_into(folder / "table1_search", sweep_study(search_plan), arguments);
  begin_stage(8, "calibration: one wand position, a flat wall, whole rigs, what it does to joints");
  calibration_into(folder / "calibration", arguments);
  begin_stage(9, "Table IV: clock errors, printed and corrected, and what a frame costs");
  recording_into(folder / "table4", arguments);
  begin_stage(10, "where in a space of simulations the conclusions hold");
  sensitivity_into(folder / "sensitivity", arguments);
  begin_stage(11, "the simulator beside reality: twins of two real sensors");
  twins_into(folder / "twins", arguments);
  begin_stage(12, "writing the report");
  const ReportFiles report = report_into(folder);
  const bool passed = table3.takes_failed + table2.takes_failed + sensors_failed == 0 &&
                      (!table3.cross_check || table3.cross_check->passed());
  if (arguments.json)
    print_json(folder, table3);
  else
    fmt::print("\n{}\nresults:  {}\ncampaign: {}\npage:     {}\n", headline_text(report.headline),
               folder.string(), (folder / "campaign").string(), (folder / "report" / "report.html").string());
  return passed ? kDone : kItemsFailed;
}

}  // namespace trilat
