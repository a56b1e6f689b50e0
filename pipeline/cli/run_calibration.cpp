// SPDX-License-Identifier: MIT
// `trilat run` for a study of kind calibration.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "pipeline/calibration_study/execute_calibration.h"
#include "pipeline/cli/part_progress.h"
#include "pipeline/cli/verbs.h"
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

}  // namespace

int run_calibration_study(const RunArguments& arguments, const Json& study) {
  if (!arguments.campaign.empty() || !arguments.calibration.empty())
    throw InputError(arguments.campaign.empty() ? "--calibration" : "--campaign",
                     "is of no use: a calibration study renders its own images");
  if (arguments.cross_check) throw InputError("--cross-check", "is for studies of kind accuracy");
  const CalibrationSpec spec = parse_calibration_spec(study, arguments.study.string());
  if (arguments.dry_run) return print_plan(spec, arguments.json);
  if (arguments.output.empty()) throw InputError("--output", "is missing: where should the results go?");
  CalibrationSummary summary;
  {
    PartProgress progress;
    summary =
        execute_calibration(spec, arguments.output,
                            {arguments.threads, stop_requested,
                             [&](const std::string& part, double share) { progress.set(part, share); }});
  }
  const std::filesystem::path folder =
      summary.interrupted ? arguments.output.string() + ".partial" : arguments.output.string();
  if (arguments.json) {
    fmt::print(
        "{}\n",
        json_text({{"results", folder.string()}, {"simulated", true}, {"interrupted", summary.interrupted}},
                  2));
  } else {
    for (const Table& table : calibration_tables(summary)) fmt::print("{}\n", markdown_of(table));
    fmt::print("results: {}\n", folder.string());
  }
  if (!summary.interrupted) return kDone;
  fmt::print(stderr, "trilat: interrupted; what was finished has been kept in {}\n", folder.string());
  return kItemsFailed;
}

}  // namespace trilat
