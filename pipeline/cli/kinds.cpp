// SPDX-License-Identifier: MIT
#include "pipeline/cli/kinds.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/cli/print_stored.h"
#include "pipeline/recording/recording_study.h"
#include "pipeline/sweep/sweep_study.h"

namespace trilat {
namespace {

// An opened study that is planned at once.
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

int print_tables(const std::filesystem::path& results, Json document, const Shown& shown) {
  if (shown.json) {
    document.update(Json{{"results", results.string()}, {"simulated", true}});
    fmt::print("{}\n", json_text(document, 2));
    return kDone;
  }
  print_stored(results, true);
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
       print_tables, calibration_study_schema},
      {StudyKind::recording, "items", "a recording study simulates its own recordings", open_recording,
       print_tables, recording_schema}};
  return kinds;
}

const Kind* find_kind(const std::string& name) {
  const auto found = std::find_if(kinds().begin(), kinds().end(),
                                  [&](const Kind& kind) { return name_of(kind.kind) == name; });
  return found == kinds().end() ? nullptr : &*found;
}

}  // namespace trilat
