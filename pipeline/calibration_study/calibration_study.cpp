// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/calibration_study.h"

#include "datasets/results/results_file.h"
#include "datasets/results/studies/calibration_summary.h"
#include "pipeline/calibration_study/distortion.h"
#include "pipeline/calibration_study/joint_effect.h"
#include "pipeline/calibration_study/rig_trials.h"
#include "pipeline/calibration_study/wand_samples.h"

namespace trilat {
namespace {

CalibrationSummary summarise(const CalibrationSpec& spec, const Outcomes& outcomes, const Watch& watch) {
  CalibrationSummary summary;
  summary.study = spec.name;
  summary.seed = spec.seed;
  summary.samples = spec.samples;
  summary.units = spec.units;
  summary.frames = spec.frames;
  summary.ball_radius_m = spec.ball_radius_m;
  summary.positions = spec.positions;
  WandSampleResults wand = read_wand(spec, outcomes);
  summary.wand = std::move(wand.rows);
  summary.wand_samples = std::move(wand.samples);
  summary.distortion = read_distortion(spec, outcomes);
  RigTrialResults rigs = read_rigs(spec, outcomes);
  summary.rigs = std::move(rigs.rows);
  summary.effect = measure_effect(spec, true_rig(spec), rigs.calibrations, watch);
  return summary;
}

}  // namespace

Study calibration_study(const CalibrationSpec& spec) {
  const Json resolved = resolved_json(spec);
  std::vector<Item> items = wand_items(spec);
  for (const auto& more : {distortion_items(spec), rig_items(spec)})
    items.insert(items.end(), more.begin(), more.end());
  return {.kind = name_of(StudyKind::calibration),
          .work = resolved,
          .items = std::move(items),
          .reduce =
              [spec](const Outcomes& outcomes, const std::filesystem::path& results, const Watch& watch) {
                write_calibration_summary(results, summarise(spec, outcomes, watch));
              },
          .manifest = [resolved](const Outcomes&) { return manifest_of_generated(resolved); }};
}

}  // namespace trilat
