// SPDX-License-Identifier: MIT
#include "pipeline/gate/night_history.h"

#include <algorithm>
#include <set>
#include <vector>

#include <fmt/format.h>

#include "datasets/results/summary.h"

namespace trilat {

namespace {

// The mean errors of all takes under the first alignment.
std::vector<Number> mean_errors_in(const ResultsSummary& summary) {
  std::vector<Number> means;
  for (const Number& number : summary.numbers.all())
    if (number.measure == "distance" && number.statistic == "mean" && number.take.empty() &&
        number.alignment == summary.alignments.front())
      means.push_back(number);
  return means;
}

}  // namespace

std::map<std::string, double> mean_errors_of(const ResultsSet& results) {
  std::map<std::string, double> errors_m;
  for (const FoundResults& found : results.results) {
    if (found.kind != StudyKind::accuracy) continue;
    const std::vector<Number> means = mean_errors_in(read_results<ResultsSummary>(found.folder));
    std::set<std::string> averaged;  // conditions of several groups
    for (const Number& mean : means)
      if (mean.group == kAverageGroup) averaged.insert(mean.condition);
    for (const Number& mean : means)
      if (mean.group == kAverageGroup || !averaged.contains(mean.condition))
        errors_m[fmt::format("{}: {}, {} (m)", found.name, mean.method, mean.condition)] = mean.value;
  }
  return errors_m;
}

std::string key_of(const GateFinding& f) {
  std::string key =
      fmt::format("{} | {} | {} | {} | {}", word_of(f.kind), f.study, f.method, f.condition, f.group);
  if (f.kind == FindingKind::number || f.kind == FindingKind::failure) key += " | " + f.what;
  std::ranges::replace(key, ';', ',');  // which separates alarms in the history
  return key;
}

std::size_t set_since(std::span<const Night> history, GateReport& report) {
  std::vector<const Night*> nights;
  for (const Night& night : history) {
    if (night.time < report.baseline_time) continue;  // judged against another baseline
    if (night.verdict == NightVerdict::accepted) nights.clear();
    nights.push_back(&night);
  }
  if (nights.empty()) return 0;
  for (GateFinding& f : report.findings) {
    if (!f.alarm) continue;
    f.since = report.time;
    const std::string key = key_of(f);
    for (auto night = nights.rbegin(); night != nights.rend(); ++night) {
      if (std::ranges::find((*night)->alarms, key) == (*night)->alarms.end()) break;
      f.since = (*night)->time;
    }
  }
  return nights.size();
}

}  // namespace trilat
