// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/results/gate_history.h"
#include "datasets/results/numbers.h"
#include "pipeline/gate/found_results.h"

namespace trilat {

struct GateLimits {
  double smallest_percent = 1.0;       // of an error or a number; less is no alarm
  double smallest_m = 1e-4;            // and of an error or a length at least so much
  double smallest_number = 1e-6;       // and of any other number
  double smallest_loss_percent = 0.5;  // of the samples answered before
  double take_loss_percent = 10.0;     // of one take's
  double false_alarm_rate = 0.01;      // of a whole night, of other recordings
};

// The kinds of findings.
enum class FindingKind : std::uint8_t {
  accuracy,  // mean absolute error of a cell
  coverage,  // how many samples of a cell are answered
  failure,   // takes that could not be evaluated, cross-checks that fail, studies that are gone
  number,    // any other number
};
template <>
inline constexpr std::array words<FindingKind>{"accuracy", "coverage", "failure", "number"};

enum class Direction : std::uint8_t { worse, better, changed };
template <>
inline constexpr std::array words<Direction>{"worse", "better", "changed"};

// A cell of a study's table; of a number of a deterministic study only the study.
struct CellName {
  std::string study, method, condition, group;
};

// A difference. Numbers that there are not are NaN.
struct GateFinding : CellName {
  FindingKind kind = FindingKind::number;
  Direction direction = Direction::changed;
  bool alarm = false;
  std::string what;  // what was measured; of a number its place
  double before = kNaN, now = kNaN;
  std::string unit;  // of before and now: "m" is printed in centimetres
  // percent: the change as a share of `before`, NaN where `before` is zero. Where recordings differ, low and
  // high bound its 95 % interval, and p_value is corrected for all comparisons (Holm).
  double percent = kNaN, low = kNaN, high = kNaN, p_value = kNaN;
  std::uint64_t clusters = 0;  // participants behind the interval
  std::string note;            // a sentence more: exact counts, which take
  std::string since;  // the first of the nights in a row that raised this alarm; empty when not known

  static void fields(auto& self, auto&& f) {
    f("kind", self.kind, "direction", self.direction, "alarm", self.alarm, "study", self.study, "method",
      self.method, "condition", self.condition, "group", self.group, "what", self.what, "unit", self.unit,
      "before", self.before, "now", self.now, "change_percent", self.percent, "change_low_percent", self.low,
      "change_high_percent", self.high, "p_value", self.p_value, "clusters", self.clusters, "note", self.note,
      "since", self.since);
  }
};

GateFinding finding_of(const CellName& cell, FindingKind kind, Direction direction, bool alarm);
// Alarms first, and what is surely worse before numbers that changed one way or the other; of each the
// largest first. Failures have no size and come before all others, numbers that were zero behind them.
void sort_findings(std::vector<GateFinding>& findings);

// Whether two numbers are equal but for rounding (1e-9 of the larger), or both are none.
bool is_same(double a, double b);
// The change as a percentage of `before`; NaN where that is zero.
double percent_of(double now, double before);

// State of one study beside the baseline.
enum class StudyState : std::uint8_t {
  identical,    // every number is the same
  compared,     // numbers differ and were judged
  not_judged,   // other recordings of too few participants to tell a change from chance
  only_now,     // not in the baseline
  only_before,  // in the baseline alone
};
template <>
inline constexpr std::array words<StudyState>{"identical", "compared", "not_judged", "only_now",
                                              "only_before"};

struct StudyVerdict {
  std::string study, kind;
  StudyState state = StudyState::compared;
  std::vector<std::string> settings;  // each that differs, with both values
  std::string note;                   // what else is to be known of the comparison
  std::size_t participants = 0;       // of a study that is not judged

  static void fields(auto& self, auto&& f) {
    f("study", self.study, "kind", self.kind, "state", self.state, "settings", self.settings, "note",
      self.note);
  }
};

struct GateReport {
  std::string time;  // UTC, ISO 8601
  std::string results, baseline;
  std::string history;                         // its file; empty when there is none
  std::string baseline_time, baseline_reason;  // when and why it was accepted; empty when not known
  double smallest_percent = 0.0;
  std::vector<StudyVerdict> studies;
  std::vector<GateFinding> findings;  // alarms first, the largest first
  std::uint64_t looked_at = 0;        // cells and numbers that were compared
  std::uint64_t within_limits = 0;    // of those, changed by less than their limits
  std::vector<std::string> notes;
  NightVerdict verdict() const;  // never `accepted`
  std::uint64_t alarms() const;
};

// The text that somebody reads in the morning: a verdict with the worst alarm, settings that differ, each
// alarm in a few lines, then what is better or to be known. Ends with a newline.
std::string gate_summary(const GateReport& report);

Json gate_json(const GateReport& report);

// "2 participants in table3": what was not judged and why; empty when all was.
std::string not_judged_text(const GateReport& report);

// Mean errors (m) that a history keeps of accuracy studies: one for each method and condition, averaged over
// the joint groups, under the study's first alignment.
std::map<std::string, double> mean_errors_of(const ResultsSet& results);

// The name of what a finding is about, the same every night; a history keeps it of each alarm.
std::string key_of(const GateFinding& finding);

// Sets "since when" of the report's alarms: the first of the nights in a row, up to the report's, that raised
// the same alarm. Returns how many nights there are since the last accepted change, without the report's.
// Nights before the report's baseline was accepted do not count. Without any night nothing is set.
std::size_t set_since(std::span<const Night> history, GateReport& report);

}  // namespace trilat
