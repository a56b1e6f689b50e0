// SPDX-License-Identifier: MIT
#include "pipeline/gate/judge_history.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>

#include <fmt/format.h>

#include "evaluators/metrics/change_points.h"

namespace trilat {
namespace {

using Values = std::map<std::string, double> HistoryEntry::*;

// One number over the nights that have it.
struct Series {
  std::vector<double> values;
  std::vector<const HistoryEntry*> nights;
};

Series series_over(std::span<const HistoryEntry* const> nights, Values values, const std::string& key) {
  Series series;
  for (const HistoryEntry* night : nights) {
    const auto found = (night->*values).find(key);
    if (found == (night->*values).end() || !std::isfinite(found->second)) continue;
    series.values.push_back(found->second);
    series.nights.push_back(night);
  }
  return series;
}

// Errors repeat to the last digits when nothing changed, times never do.
Segmentation segmented(const Series& series, bool noisy) {
  constexpr double kSameShare = 1e-6;
  ChangePointOptions options;
  options.shortest = noisy ? 3 : 1;
  options.least_sigma =
      std::max(1e-300, kSameShare * std::abs(series.values.empty() ? 0.0 : series.values[0]));
  return find_change_points(series.values, options);
}

// Since when the series is where it is tonight; empty when it has always been there.
std::string since_by_level(const Series& series, bool noisy) {
  const Segmentation found = segmented(series, noisy);
  if (found.stretches.size() < 2) return "";
  return series.nights[found.stretches.back().first]->time;
}

// Since when the same alarm is raised night by night.
std::string since_by_alarm(std::span<const HistoryEntry* const> nights, const std::string& key) {
  std::string since;
  for (auto night = nights.rbegin(); night != nights.rend(); ++night) {
    const auto& alarms = (*night)->alarms;
    if (std::find(alarms.begin(), alarms.end(), key) == alarms.end()) break;
    since = (*night)->time;
  }
  return since;
}

bool is_speed(const GateFinding& f) { return f.kind == FindingKind::speed; }

std::string since_of(const GateFinding& f, std::span<const HistoryEntry* const> nights) {
  std::string since;
  if (f.kind == FindingKind::accuracy)
    since = since_by_level(
        series_over(nights, &HistoryEntry::error_m, series_of(f.study, f.method, f.condition, f.group)),
        false);
  if (f.kind == FindingKind::coverage)
    since = since_by_level(
        series_over(nights, &HistoryEntry::coverage, series_of(f.study, f.method, f.condition, f.group)),
        false);
  if (is_speed(f)) since = since_by_level(series_over(nights, &HistoryEntry::speed, f.method), true);
  if (since.empty()) since = since_by_alarm(nights, key_of(f));
  return since;
}

std::vector<GateFinding> drifts_of(std::span<const HistoryEntry* const> nights, Values values, bool noisy,
                                   double smallest_percent, const std::set<std::string>& alarmed) {
  std::vector<GateFinding> drifts;
  for (const auto& [key, tonight] : nights.back()->*values) {
    const Series series = series_over(nights, values, key);
    if (series.values.size() < 2 * kFewestDriftNights || alarmed.contains(key)) continue;
    const Segmentation found = segmented(series, noisy);
    const Stretch &first = found.stretches.front(), &last = found.stretches.back();
    const double percent = 100.0 * (last.level - first.level) / first.level;
    if (found.stretches.size() < 2 || last.end - last.first < kFewestDriftNights ||
        !(std::abs(percent) > smallest_percent))
      continue;
    GateFinding drift;
    drift.kind = FindingKind::drift;
    drift.direction = percent > 0.0 ? Direction::worse : Direction::better;
    drift.alarm = percent > 0.0;
    drift.study = noisy ? "speed" : "history";
    drift.method = key;
    drift.what = noisy ? "time against the reference" : "mean absolute error (m)";
    drift.before = first.level;
    drift.now = last.level;
    drift.percent = percent;
    drift.n = series.values.size();
    drift.since = series.nights[last.first]->time;
    drift.note = fmt::format("over {} nights, in {} steps", series.values.size(), found.stretches.size() - 1);
    drifts.push_back(drift);
  }
  return drifts;
}

}  // namespace

std::string series_of(const std::string& study, const std::string& method, const std::string& condition,
                      const std::string& group) {
  return study + " | " + method + " | " + condition + " | " + group;
}

std::string key_of(const GateFinding& f) {
  std::string key = std::string(name_of(f.kind)) + " | " +
                    series_of(f.study, f.method, f.condition, f.group) + " | " + f.alignment;
  if (f.kind == FindingKind::number || f.kind == FindingKind::failure) key += " | " + f.what;
  return key;
}

HistoryJudgement judge_history(const History& history, const HistoryEntry& tonight, const GateLimits& limits,
                               std::vector<GateFinding>& findings) {
  std::vector<const HistoryEntry*> nights;
  for (const HistoryEntry& entry : history.entries) {
    if (entry.accepted) nights.clear();  // the series begins anew, with what was accepted
    nights.push_back(&entry);
  }
  HistoryJudgement judgement;
  judgement.nights = nights.size();
  nights.push_back(&tonight);
  std::set<std::string> errors, speeds;
  for (GateFinding& f : findings) {
    if (judgement.nights > 0) f.since = since_of(f, nights);
    if (!f.alarm) continue;
    if (f.kind == FindingKind::accuracy) errors.insert(series_of(f.study, f.method, f.condition, f.group));
    if (is_speed(f)) speeds.insert(f.method);
  }
  judgement.drifts = drifts_of(nights, &HistoryEntry::error_m, false, limits.smallest_percent, errors);
  for (GateFinding& drift :
       drifts_of(nights, &HistoryEntry::speed, true, kSmallestSpeedDrift_percent, speeds))
    judgement.drifts.push_back(std::move(drift));
  return judgement;
}

}  // namespace trilat
