// SPDX-License-Identifier: MIT
#include "datasets/results/paper_evidence.h"

#include <algorithm>

#include "datasets/results/results_file.h"

namespace trilat {
namespace {

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

}  // namespace

void PaperEvidence::add(const ResultsSummary& s) {
  if (has(s.methods, "nonlinear, 8 sensors")) {
    sensor_counts.push_back(s);
    return;
  }
  if (!walking && has(s.conditions, "walking") && has(s.methods, "nonlinear")) walking = s;
  if (!occluded && (has(s.conditions, occluded_condition("arm_swing")) ||
                    has(s.conditions, occluded_condition("leg_crossing"))))
    occluded = s;
}

bool PaperEvidence::any_simulated() const {
  return (walking && walking->simulated) || (occluded && occluded->simulated) ||
         std::ranges::any_of(sensor_counts, [](const ResultsSummary& s) { return s.simulated; }) || sweep ||
         calibration || recording;
}

PaperEvidence read_paper_evidence(const std::vector<std::filesystem::path>& results) {
  PaperEvidence evidence;
  for (const std::filesystem::path& folder : results) {
    const StudyKind kind = results_kind(folder);
    if (kind == StudyKind::accuracy) evidence.add(read_summary(folder));
    if (kind == StudyKind::calibration && !evidence.calibration)
      evidence.calibration = read_results<CalibrationSummary>(folder);
    if (kind == StudyKind::recording && !evidence.recording)
      evidence.recording = read_results<RecordingSummary>(folder);
    if (kind != StudyKind::threshold_sweep || evidence.sweep) continue;
    if (SweepSummary sweep = read_results<SweepSummary>(folder); sweep.search)
      evidence.sweep = std::move(sweep);
  }
  return evidence;
}

}  // namespace trilat
