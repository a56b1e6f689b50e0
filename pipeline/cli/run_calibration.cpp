// SPDX-License-Identifier: MIT
// `trilat run` for a study of kind calibration.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/calibration_study/execute_calibration.h"
#include "pipeline/cli/merge_kinds.h"
#include "pipeline/cli/part_progress.h"
#include "pipeline/cli/reused_results.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/results_folder.h"
#include "reports/calibration_tables.h"
#include "reports/render.h"

namespace trilat {
namespace {

int print_plan(const CalibrationSpec& spec, bool json) {
  const std::uint64_t images = 2 * spec.units * (spec.samples + spec.near_samples) * spec.frames +
                               spec.distortion_units * spec.distortion_frames +
                               spec.runs * spec.positions * spec.position_frames * spec.rig.heights_m.size();
  if (json) {
    fmt::print("{}\n", json_text({{"study", resolved_json(spec)}, {"images", images}}, 2));
    return kDone;
  }
  fmt::print(
      "study {} (simulated): {} samples of each of {} units in two scenes, a wall in {} frames of {} units, "
      "{} rigs with {} wand positions; {} depth images to render\n",
      spec.name, spec.samples + spec.near_samples, spec.units, spec.distortion_frames, spec.distortion_units,
      spec.runs, spec.positions, images);
  return kDone;
}

int print_results(const CalibrationSummary& summary, const std::filesystem::path& output, Json document,
                  bool json) {
  const std::filesystem::path folder = summary.interrupted ? partial_name(output_name(output)) : output;
  if (json) {
    document.update(
        Json{{"results", folder.string()}, {"simulated", true}, {"interrupted", summary.interrupted}});
    fmt::print("{}\n", json_text(document, 2));
  } else {
    for (const Table& table : calibration_tables(summary)) fmt::print("{}\n", markdown_of(table));
    fmt::print("results: {}\n", folder.string());
  }
  if (!summary.interrupted) return kDone;
  tell_interrupted(folder);
  return kItemsFailed;
}

}  // namespace

int run_calibration_study(const RunArguments& arguments, const Json& study) {
  if (!arguments.campaign.empty() || !arguments.calibration.empty())
    throw InputError(arguments.campaign.empty() ? "--calibration" : "--campaign",
                     "is of no use: a calibration study renders its own images");
  if (arguments.cross_check) throw InputError("--cross-check", "is for studies of kind accuracy");
  const CalibrationSpec spec = parse_calibration_spec(study, arguments.study.string());
  if (arguments.dry_run) return print_plan(spec, arguments.json);
  check_run_output(arguments, ResultsKind::calibration);
  ItemTally tally;
  const WorkOptions work = work_options(arguments);
  CalibrationSummary summary;
  {
    PartProgress progress;
    summary = execute_calibration(spec, arguments.output,
                                  {arguments.threads, stop_requested,
                                   [&](const std::string& part, double share) { progress.set(part, share); },
                                   work, arguments.fresh, &tally});
  }
  tell_reuse("items", tally);
  if (!work.shard.whole() && summary.interrupted) throw Interrupted();
  if (!work.shard.whole()) {
    print_part(arguments.output, work.shard, tally, arguments.json);
    return kDone;
  }
  return print_results(summary, arguments.output, tally_json(tally), arguments.json);
}

int merge_calibration_study(const MergeArguments& arguments, const std::vector<FoundPart>& parts) {
  CalibrationSummary summary;
  {
    PartProgress progress;
    ExecuteCalibrationOptions options{.threads = arguments.threads, .stop_requested = stop_requested};
    options.progress = [&](const std::string& part, double share) { progress.set(part, share); };
    summary = merge_calibration(parts, arguments.output, options);
  }
  return print_results(summary, arguments.output, {{"parts", parts.size()}}, arguments.json);
}

}  // namespace trilat
