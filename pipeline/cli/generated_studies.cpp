// SPDX-License-Identifier: MIT
#include "pipeline/cli/generated_studies.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/synthetic/error_sources.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/cli/budget_study.h"
#include "pipeline/cli/embedded_studies.h"
#include "pipeline/cli/time_capture.h"
#include "pipeline/recording_study/recording_study.h"
#include "reports/budget_tables.h"
#include "reports/calibration_tables.h"
#include "reports/table4.h"

namespace trilat {
namespace {

OpenedStudy open_calibration(const RunArguments& arguments, const Json& study) {
  const CalibrationSpec spec = parse_calibration_spec(study, arguments.study.string());
  const std::uint64_t images = 2 * spec.units * (spec.samples + spec.near_samples) * spec.frames +
                               spec.distortion_units * spec.distortion_frames +
                               spec.runs * spec.positions * spec.position_frames * spec.rig.heights_m.size();
  return {
      calibration_study(spec),
      {{"study", resolved_json(spec)}, {"images", images}},
      fmt::format("study {} (simulated): {} samples of each of {} units in two scenes, a wall in {} frames "
                  "of {} units, {} rigs with {} wand positions; {} depth images to render",
                  spec.name, spec.samples + spec.near_samples, spec.units, spec.distortion_frames,
                  spec.distortion_units, spec.runs, spec.positions, images)};
}

OpenedStudy open_recording(const RunArguments& arguments, const Json& study) {
  const RecordingSpec spec = parse_recording_spec(study, arguments.study.string());
  return {
      recording_study(spec, time_capture),
      {{"study", resolved_json(spec)}, {"samples_of_each_network", spec.runs * spec.sensors * spec.frames}},
      fmt::format("study {} (simulated): {} networks, of each {} runs x {} sensors x {} frames; {} methods "
                  "timed on {} frames",
                  spec.name, spec.networks.size(), spec.runs, spec.sensors, spec.frames, spec.methods.size(),
                  spec.frames)};
}

OpenedStudy open_budget(const RunArguments& arguments, const Json& study) {
  const char* place = "pipeline/studies/paper_campaign.json";
  const SimulationSpec paper = parse_simulation(parse_json(embedded::paper_campaign_json, place), place, {});
  const std::filesystem::path folder = arguments.study.parent_path();
  const BudgetSpec spec = parse_budget(study, arguments.study.string(), folder, paper, arguments.outside);
  OpenedStudy opened{
      budget_study(spec, arguments.memory_mb ? *arguments.memory_mb * 1'000'000 : half_of_memory_bytes()),
      {{"study", resolved_json(spec.study)},
       {"participants", spec.simulation.participants},
       {"campaigns", error_sources().size()}},
      fmt::format("study {} (simulated): {} campaigns of {} participants, one for every source of error",
                  spec.study.name, error_sources().size(), spec.simulation.participants)};
  if (study.contains("simulation")) opened.inputs = {folder / study["simulation"].get<std::string>()};
  return opened;
}

}  // namespace

const std::vector<GeneratedKind>& generated_kinds() {
  static const std::vector<GeneratedKind> kinds{
      {StudyKind::calibration, "items", "a calibration study renders its own images", open_calibration,
       [](const Json& work, const std::string& place) {
         return calibration_study(parse_calibration_spec(work, place));
       },
       [](const std::filesystem::path& results) {
         return calibration_tables(read_calibration_summary(results));
       }},
      {StudyKind::error_budget, "sources of error",
       "an error budget simulates its own campaigns; name their simulation.json in the study, as "
       "\"simulation\"",
       open_budget, budget_of_parts,
       [](const std::filesystem::path& results) { return budget_tables(read_budget_summary(results)); }},
      {StudyKind::recording, "items", "a recording study simulates its own recordings", open_recording,
       [](const Json& work, const std::string& place) {
         return recording_study(parse_recording_spec(work, place));
       },
       [](const std::filesystem::path& results) {
         return table4(read_recording_summary(results), read_stage_timings(results));
       }}};
  return kinds;
}

const GeneratedKind* generated_kind(const std::string& name) {
  const auto found = std::find_if(generated_kinds().begin(), generated_kinds().end(),
                                  [&](const GeneratedKind& kind) { return name_of(kind.kind) == name; });
  return found == generated_kinds().end() ? nullptr : &*found;
}

}  // namespace trilat
