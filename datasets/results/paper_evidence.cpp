// SPDX-License-Identifier: MIT
#include "datasets/results/paper_evidence.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/results/results_file.h"

namespace trilat {
bool PaperEvidence::any_simulated() const {
  return (walking && walking->simulated) || (occluded && occluded->simulated) ||
         std::ranges::any_of(sensor_counts, [](const ResultsSummary& s) { return s.simulated; }) || sweep ||
         calibration || recording;
}

std::vector<ClaimNumber> PaperEvidence::claims() const {
  std::vector<ClaimNumber> numbers;
  const auto add = [&](const auto& summary) {
    numbers.insert(numbers.end(), summary.claims.begin(), summary.claims.end());
  };
  const auto add_any = [&](const auto& summary) {
    if (summary) add(*summary);
  };
  add_any(walking);
  add_any(occluded);
  std::ranges::for_each(sensor_counts, add);
  add_any(sweep);
  add_any(calibration);
  add_any(recording);
  return numbers;
}

PaperEvidence read_paper_evidence(const std::vector<std::filesystem::path>& results) {
  PaperEvidence evidence;
  std::map<std::string, std::filesystem::path> known;
  const auto is_first = [&](const std::string& study, const std::filesystem::path& folder) {
    const auto [found, is_new] = known.emplace(study, folder);
    if (!is_new)
      throw InputError(folder.string(),
                       fmt::format("holds results of the study \"{}\", as {} does; the paper's claims are "
                                   "judged by one of them",
                                   study, found->second.string()));
    return true;
  };
  const auto take = [&](auto& slot, auto summary, const std::filesystem::path& folder) {
    if (is_first(summary.study, folder)) slot = std::move(summary);
  };
  for (const std::filesystem::path& folder : results) {
    const StudyKind kind = results_kind(folder);
    if (kind == StudyKind::accuracy) {
      ResultsSummary summary = read_summary(folder);
      if (summary.study == "table3")
        take(evidence.walking, std::move(summary), folder);
      else if (summary.study == "table2")
        take(evidence.occluded, std::move(summary), folder);
      else if (summary.study.starts_with("sensors_") && is_first(summary.study, folder))
        evidence.sensor_counts.push_back(std::move(summary));
    } else if (kind == StudyKind::calibration) {
      if (auto summary = read_results<CalibrationSummary>(folder); summary.study == "calibration")
        take(evidence.calibration, std::move(summary), folder);
    } else if (kind == StudyKind::recording) {
      if (auto summary = read_results<RecordingSummary>(folder); summary.study == "table4")
        take(evidence.recording, std::move(summary), folder);
    } else if (kind == StudyKind::threshold_sweep) {
      if (auto summary = read_results<SweepSummary>(folder); summary.study == "table1_search")
        take(evidence.sweep, std::move(summary), folder);
    }
  }
  return evidence;
}

}  // namespace trilat
