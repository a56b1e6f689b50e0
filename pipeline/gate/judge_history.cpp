// SPDX-License-Identifier: MIT
#include "pipeline/gate/judge_history.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <span>

#include <fmt/format.h>

#include "evaluators/metrics/change_points.h"
#include "evaluators/metrics/holm.h"
#include "evaluators/metrics/student.h"
#include "evaluators/metrics/student_tail.h"

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

// What is kept of every night, and how a drift of it is judged and told.
struct Kept {
  Values values;
  bool noisy;  // differs every night
  bool more_is_worse;
  double smallest_percent;
  const char *what, *unit;
};

// How far the last level is from the first: with the noise around all levels, Student's t. The change points
// were chosen among so many places, which the chance allows for.
struct LevelChange {
  double percent = GateFinding::kNone, low = GateFinding::kNone, high = GateFinding::kNone, chance = 1.0;
};

LevelChange level_change(const Series& series, const Segmentation& found) {
  const Stretch &first = found.stretches.front(), &last = found.stretches.back();
  const auto count = [](const Stretch& s) { return static_cast<double>(s.end - s.first); };
  const std::size_t degrees = series.values.size() - found.stretches.size();
  const double se = found.sigma * std::sqrt(1.0 / count(first) + 1.0 / count(last));
  const double difference = last.level - first.level, scale = 100.0 / first.level;
  const double spread = student_quantile(degrees) * se;
  const auto places = static_cast<double>(series.values.size() - 1);
  return {scale * difference, scale * (difference - spread), scale * (difference + spread),
          std::min(1.0, places * student_two_sided(difference / se, degrees))};
}

constexpr std::string_view kBetweenNames = " | ";

// What series_of() made a key of; a solver's key is its name.
void name_cell(const std::string& key, GateFinding& drift) {
  std::vector<std::string> names;
  std::size_t first = 0;
  for (std::size_t end = 0; (end = key.find(kBetweenNames, first)) != std::string::npos;
       first = end + kBetweenNames.size())
    names.push_back(key.substr(first, end - first));
  names.push_back(key.substr(first));
  drift.study = "speed";
  drift.method = key;
  if (names.size() != 4) return;
  drift.study = names[0];
  drift.method = names[1];
  drift.condition = names[2];
  drift.group = names[3];
}

std::vector<GateFinding> drifts_of(std::span<const HistoryEntry* const> nights, const Kept& kept,
                                   const std::set<std::string>& alarmed) {
  std::vector<GateFinding> drifts;
  for (const auto& [key, tonight] : nights.back()->*kept.values) {
    const Series series = series_over(nights, kept.values, key);
    if (series.values.size() < 2 * kFewestDriftNights || alarmed.contains(key)) continue;
    const Segmentation found = segmented(series, kept.noisy);
    const Stretch &first = found.stretches.front(), &last = found.stretches.back();
    if (found.stretches.size() < 2 || last.end - last.first < kFewestDriftNights ||
        series.values.size() <= found.stretches.size() || first.level == 0.0)
      continue;
    const LevelChange change = level_change(series, found);
    if (!(std::abs(change.percent) > kept.smallest_percent)) continue;
    GateFinding drift;
    drift.kind = FindingKind::drift;
    drift.direction = (change.percent > 0.0) == kept.more_is_worse ? Direction::worse : Direction::better;
    drift.alarm = drift.direction == Direction::worse;
    name_cell(key, drift);
    drift.what = kept.what;
    drift.unit = kept.unit;
    drift.before = first.level;
    drift.now = last.level;
    drift.percent = change.percent;
    drift.percent_low = change.low;
    drift.percent_high = change.high;
    drift.chance = change.chance;
    drift.n = series.values.size();
    drift.since = series.nights[last.first]->time;
    drift.note = fmt::format("over {} nights, in {} steps", series.values.size(), found.stretches.size() - 1);
    drifts.push_back(drift);
  }
  return drifts;
}

// Those that are not chance, by Holm over all series of the night.
std::vector<GateFinding> significant(std::vector<GateFinding> drifts, std::size_t series, double alpha) {
  std::vector<double> chances;
  for (const GateFinding& drift : drifts) chances.push_back(drift.chance);
  chances.resize(std::max(series, drifts.size()), 1.0);  // the others show nothing
  const std::vector<double> adjusted = holm_adjusted(chances);
  std::vector<GateFinding> left;
  for (std::size_t d = 0; d < drifts.size(); ++d) {
    drifts[d].chance = adjusted[d];
    if (adjusted[d] <= alpha) left.push_back(std::move(drifts[d]));
  }
  return left;
}

}  // namespace

std::string series_of(const std::string& study, const std::string& method, const std::string& condition,
                      const std::string& group) {
  return study + " | " + method + " | " + condition + " | " + group;
}

std::string key_of(const GateFinding& f) {
  std::string key = std::string(name_of(f.kind)) + " | " +
                    series_of(f.study, f.method, f.condition, f.group) + " | " + f.alignment;
  if (f.kind == FindingKind::number || f.kind == FindingKind::failure || f.kind == FindingKind::status)
    key += " | " + f.what;
  return key;
}

HistoryJudgement judge_history(const History& history, const HistoryEntry& tonight, const GateLimits& limits,
                               std::vector<GateFinding>& findings, const std::string& accepted_time) {
  std::vector<const HistoryEntry*> nights;
  for (const HistoryEntry& entry : history.entries) {
    if (entry.time < accepted_time) continue;  // judged against another baseline
    if (entry.accepted) nights.clear();        // the series begins anew, with what was accepted
    nights.push_back(&entry);
  }
  HistoryJudgement judgement;
  judgement.nights = nights.size();
  nights.push_back(&tonight);
  std::set<std::string> errors, coverages, speeds;
  for (GateFinding& f : findings) {
    if (judgement.nights > 0) f.since = since_of(f, nights);
    if (!f.alarm) continue;
    const std::string series = series_of(f.study, f.method, f.condition, f.group);
    if (f.kind == FindingKind::accuracy) errors.insert(series);
    if (f.kind == FindingKind::coverage) coverages.insert(series);
    if (is_speed(f)) speeds.insert(f.method);
  }
  const Kept error{&HistoryEntry::error_m,    false, true, limits.smallest_percent,
                   "mean absolute error (m)", "m"};
  const Kept coverage{&HistoryEntry::coverage,     false, false, limits.smallest_loss_percent,
                      "share of samples answered", ""};
  const Kept speed{&HistoryEntry::speed,         true, true, kSmallestSpeedDrift_percent,
                   "time against the reference", ""};
  const auto add = [&](const Kept& kept, const std::set<std::string>& alarmed) {
    auto drifts = drifts_of(nights, kept, alarmed);
    std::move(drifts.begin(), drifts.end(), std::back_inserter(judgement.drifts));
  };
  add(error, errors);
  add(coverage, coverages);
  add(speed, speeds);
  const std::size_t series = tonight.error_m.size() + tonight.coverage.size() + tonight.speed.size();
  judgement.drifts = significant(std::move(judgement.drifts), series, kDriftShare * limits.chance);
  return judgement;
}

}  // namespace trilat
