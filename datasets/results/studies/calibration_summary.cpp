// SPDX-License-Identifier: MIT
#include "datasets/results/studies/calibration_summary.h"

#include <algorithm>

#include "datasets/results/results_file.h"

namespace trilat {

void DistortionCurve::check(const JsonObject& object) const {
  for (const auto* curve : {&depth_error_m, &depth_residual_m, &printed_error_m, &lens_error_m})
    if (curve->size() != valid.size()) object.refuse("valid", "must be as long as the curves");
}

void CalibrationSummary::check(const JsonObject& object) const {
  const auto has_row = [&](const WandSample& sample) { return sample.row < wand.size(); };
  if (!std::all_of(wand_samples.begin(), wand_samples.end(), has_row))
    object.refuse("wand_samples", "must be of rows that are there");
}

void write_calibration_summary(const std::filesystem::path& folder, const CalibrationSummary& summary) {
  write_results(folder, StudyKind::calibration, summary, -1);
}

CalibrationSummary read_calibration_summary(const std::filesystem::path& folder) {
  return read_results<CalibrationSummary>(folder, StudyKind::calibration);
}

}  // namespace trilat
