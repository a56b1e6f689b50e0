// SPDX-License-Identifier: MIT
#include "pipeline/cli/kinds.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/synthetic/error_sources.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/budget/budget_study.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/cli/embedded_campaigns.h"
#include "pipeline/recording/recording_study.h"
#include "pipeline/sensitivity/sensitivity_study.h"
#include "pipeline/sweep/sweep_study.h"
#include "reports/render/render.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

// Of a study that is planned at once.
OpenedStudy opened(Study study, const Json& plan, const std::string& text) {
  return {.plan = [study = std::move(study)](const Watch&) { return study; },
          .print_plan =
              [plan, text](const Shard&, bool json, const Watch&) {
                fmt::print("{}\n", json ? json_text(plan, 2) : text);
                return int{kDone};
              }};
}

OpenedStudy open_calibration(const RunArguments& arguments, const Json& study) {
  const CalibrationSpec spec = parse_calibration_spec(study, arguments.study.string());
  const std::uint64_t images = 2 * spec.units * (spec.samples + spec.near_samples) * spec.frames +
                               spec.distortion_units * spec.distortion_frames +
                               spec.runs * spec.positions * spec.position_frames * spec.rig.heights_m.size();
  return opened(
      calibration_study(spec), {{"study", resolved_json(spec)}, {"images", images}},
      fmt::format("study {} (simulated): {} samples of each of {} units in two scenes, a wall in {} frames "
                  "of {} units, {} rigs with {} wand positions; {} depth images to render",
                  spec.name, spec.samples + spec.near_samples, spec.units, spec.distortion_frames,
                  spec.distortion_units, spec.runs, spec.positions, images));
}

OpenedStudy open_recording(const RunArguments& arguments, const Json& study) {
  const RecordingSpec spec = parse_recording_spec(study, arguments.study.string());
  return opened(
      recording_study(spec),
      {{"study", resolved_json(spec)}, {"samples_of_each_network", spec.runs * spec.sensors * spec.frames}},
      fmt::format("study {} (simulated): {} networks, of each {} runs x {} sensors x {} frames; {} methods "
                  "timed on {} frames",
                  spec.name, spec.networks.size(), spec.runs, spec.sensors, spec.frames, spec.methods.size(),
                  spec.frames));
}

OpenedStudy open_budget(const RunArguments& arguments, const Json& study) {
  const char* place = "pipeline/studies/paper_campaign.json";
  const SimulationSpec paper = parse_simulation(parse_json(embedded::paper_campaign_json, place), place, {});
  const std::filesystem::path folder = arguments.study.parent_path();
  const BudgetSpec spec = parse_budget(study, arguments.study.string(), folder, paper);
  OpenedStudy budget = opened(
      budget_study(spec),
      {{"study", resolved_json(spec.study)},
       {"participants", spec.simulation.participants},
       {"campaigns", error_sources().size()}},
      fmt::format("study {} (simulated): {} campaigns of {} participants, one for every source of error",
                  spec.study.name, error_sources().size(), spec.simulation.participants));
  if (study.contains("simulation")) budget.inputs = {folder / study["simulation"].get<std::string>()};
  return budget;
}

OpenedStudy open_sensitivity(const RunArguments& arguments, const Json& study) {
  const SensitivitySpec spec =
      parse_sensitivity(study, arguments.study.string(), arguments.study.parent_path(),
                        parse_json(embedded::paper_campaign_json, "pipeline/studies/paper_campaign.json"));
  const std::size_t campaigns = campaigns_of(spec);
  return opened(sensitivity_study(spec), {{"study", resolved_json(spec)}, {"campaigns", campaigns}},
                fmt::format("study {} (simulated): {} campaigns of {} participants over {} settings",
                            spec.head.study, campaigns, spec.head.participants, spec.head.factors.size()));
}

int print_tables(const std::filesystem::path& results, const std::vector<Table>& tables, Json document,
                 const Shown& shown) {
  if (shown.json) {
    document.update(Json{{"results", results.string()}, {"simulated", true}});
    fmt::print("{}\n", json_text(document, 2));
    return kDone;
  }
  for (const Table& table : tables) fmt::print("{}\n", markdown_of(table));
  fmt::print("results: {}\n", results.string());
  return kDone;
}

}  // namespace

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> kinds{
      {StudyKind::accuracy, "takes", "", open_accuracy, print_accuracy, accuracy_schema},
      {StudyKind::threshold_sweep, "items",
       "a threshold sweep makes its own trials and places its own sensors", open_sweep, print_sweep,
       sweep_schema},
      {StudyKind::calibration, "items", "a calibration study renders its own images", open_calibration,
       [](const std::filesystem::path& results, Json document, const Shown& shown) {
         return print_tables(results, calibration_tables(read_results<CalibrationSummary>(results)),
                             std::move(document), shown);
       },
       calibration_study_schema},
      {StudyKind::error_budget, "sources of error",
       "an error budget simulates its own campaigns; name their simulation.json in the study, as "
       "\"simulation\"",
       open_budget,
       [](const std::filesystem::path& results, Json document, const Shown& shown) {
         return print_tables(results, budget_tables(read_results<BudgetSummary>(results)),
                             std::move(document), shown);
       },
       budget_schema},
      {StudyKind::recording, "items", "a recording study simulates its own recordings", open_recording,
       [](const std::filesystem::path& results, Json document, const Shown& shown) {
         return print_tables(
             results, table4(read_results<RecordingSummary>(results), read_beside<StageTimings>(results)),
             std::move(document), shown);
       },
       recording_schema},
      {StudyKind::sensitivity, "rows of campaigns",
       "a sensitivity study simulates its own campaigns; say in the study, as \"simulation\", what they have "
       "in common",
       open_sensitivity,
       [](const std::filesystem::path& results, Json document, const Shown& shown) {
         const SensitivitySummary summary = read_sensitivity_summary(results);
         const int code = print_tables(results, sensitivity_tables(summary), std::move(document), shown);
         const std::size_t failed = failed_points(summary);
         if (failed > 0)
           fmt::print(stderr, "failed: {} of {} campaigns have no errors; {} names why\n", failed,
                      summary.points.size(), (results / "points.csv").string());
         return failed > 0 ? int{kItemsFailed} : code;
       },
       sensitivity_schema}};
  return kinds;
}

const Kind* find_kind(const std::string& name) {
  const auto found = std::find_if(kinds().begin(), kinds().end(),
                                  [&](const Kind& kind) { return name_of(kind.kind) == name; });
  return found == kinds().end() ? nullptr : &*found;
}

}  // namespace trilat
