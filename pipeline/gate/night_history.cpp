// SPDX-License-Identifier: MIT
#include "pipeline/gate/night_history.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "datasets/results/summary.h"

namespace trilat {
namespace {

std::string series_of(const std::string& study, const std::string& method, const std::string& condition,
                      const std::string& group) {
  return study + " | " + method + " | " + condition + " | " + group;
}

bool raised(const HistoryEntry& night, const std::string& key) {
  return std::ranges::find(night.alarms, key) != night.alarms.end();
}

}  // namespace

void add_series(const ResultsSet& results, HistoryEntry& entry) {
  for (const FoundResults& found : results.results) {
    if (found.kind != StudyKind::accuracy) continue;
    const ResultsSummary summary = read_summary(found.folder);
    for (const Number& number : summary.numbers.all()) {
      if (number.alignment != summary.alignments.front() || !number.take.empty()) continue;
      const std::string key = series_of(found.name, number.method, number.condition, number.group);
      if (number.measure == "distance" && number.statistic == "mean") entry.error_m[key] = number.value;
      if (number.measure == "answered" && number.statistic == "share") entry.coverage[key] = number.value;
    }
  }
}

std::string key_of(const GateFinding& f) {
  std::string key = std::string(name_of(f.kind)) + " | " + series_of(f.study, f.method, f.condition, f.group);
  if (f.kind == FindingKind::number || f.kind == FindingKind::failure) key += " | " + f.what;
  return key;
}

std::size_t set_since(const History& history, GateReport& report) {
  std::vector<const HistoryEntry*> nights;
  for (const HistoryEntry& entry : history.entries) {
    if (entry.time < report.baseline_time) continue;  // judged against another baseline
    if (entry.accepted) nights.clear();
    nights.push_back(&entry);
  }
  if (nights.empty()) return 0;
  for (GateFinding& f : report.findings) {
    if (!f.alarm) continue;
    f.since = report.time;
    const std::string key = key_of(f);
    for (auto night = nights.rbegin(); night != nights.rend() && raised(**night, key); ++night)
      f.since = (*night)->time;
  }
  return nights.size();
}

}  // namespace trilat
