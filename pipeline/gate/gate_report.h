// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/results/summary.h"

namespace trilat {

// What is looked at.
enum class FindingKind : std::uint8_t {
  accuracy,  // mean absolute error of a cell, on the samples that both nights answered
  coverage,  // how many samples of a cell are answered
  status,    // how a cell's answers ended
  failure,   // takes that could not be evaluated, cross-checks that fail
  number,    // a number of a deterministic study
};
const char* name_of(FindingKind kind);

enum class Direction : std::uint8_t { worse, better, changed };
const char* name_of(Direction direction);

// Percent, its 95 % interval, and the probability that so much is chance; NaN where nobody can say.
struct Change {
  double percent = kNoNumber, low = kNoNumber, high = kNoNumber, chance = kNoNumber;
};

// A cell of a study's table; of a number of a deterministic study only the study.
struct CellName {
  std::string study, method, condition, group, alignment;
};

// A difference. Numbers that there are not are NaN.
struct GateFinding : CellName {
  FindingKind kind = FindingKind::number;
  Direction direction = Direction::changed;
  bool alarm = false;
  std::string what;  // what was measured, with its unit: "mean absolute error (m)"; of a number its place
  double before = kNoNumber, now = kNoNumber;
  std::string unit;  // of before and now, when `what` names none they can be told in: "m" is told in cm
  Change change;     // of before; the chance is corrected for all that was looked at
  std::uint64_t n = 0, clusters = 0;
  std::string note;   // a sentence more: exact counts, which take
  std::string since;  // the first of the nights in a row that raised this alarm; empty when not known
  std::string command;

  static void fields(auto& self, auto&& field) {
    field("kind", name_of(self.kind));
    field("direction", name_of(self.direction));
    TRILAT_EACH(alarm, study, method, condition, group, alignment, what, unit, before, now)
    field("change_percent", self.change.percent);
    field("change_low_percent", self.change.low);
    field("change_high_percent", self.change.high);
    field("chance", self.change.chance);
    TRILAT_EACH(n, clusters, note, since, command)
  }
};

// One cell that was compared and is not identical, whether or not it is a finding.
struct ComparedCell : CellName {
  double before_m = kNoNumber, now_m = kNoNumber;  // on the samples that both answered
  Change error;    // of before_m. Chances are of the cell by itself, not corrected
  Change lost;     // 100 (lost - gained) / asked
  Change clamped;  // 100 (clamped now - clamped before) / both
  std::uint64_t both = 0, clusters = 0;
  std::uint64_t asked = 0, answered_before = 0, answered_now = 0, lost_samples = 0, gained_samples = 0;
  // The take that lost the largest share of its answers.
  std::string worst_take;
  std::uint64_t worst_take_answered_before = 0, worst_take_answered_now = 0;
  double moved_percent = 0.0;  // of the samples asked: how many must have another status, at least
  std::string status_changes;  // "converged 3000 -> 0, clamped 0 -> 3000"; empty when there are none

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(study, method, condition, group, alignment, before_m, now_m)
    field("change_percent", self.error.percent);
    field("change_low_percent", self.error.low);
    field("change_high_percent", self.error.high);
    field("n", self.both);
    TRILAT_EACH(clusters, asked, answered_before, answered_now)
    field("lost", self.lost_samples);
    field("gained", self.gained_samples);
  }
};

// How one study stands against the baseline.
enum class StudyState : std::uint8_t {
  identical,    // equal to the byte
  same_values,  // other bytes, the same numbers
  compared,     // numbers differ and were judged
  not_judged,   // numbers differ, and too few participants to tell a change from chance
  only_now,     // not in the baseline
  only_before,  // in the baseline alone
};
const char* name_of(StudyState state);

struct StudyVerdict {
  std::string study, kind;
  StudyState state = StudyState::compared;
  std::string note;              // what else is to be known of the comparison
  std::size_t participants = 0;  // of a study that is not judged

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(study, kind)
    field("state", name_of(self.state));
    TRILAT_EACH(note)
  }
};

// A regression that was found counts, whatever was not judged beside it.
enum class Verdict : std::uint8_t { quiet, regression, not_judged };
const char* name_of(Verdict verdict);

struct GateReport {
  std::string time;  // UTC, ISO 8601
  std::string results, baseline;
  std::string history;                         // its file; empty when there is none
  std::string baseline_time, baseline_reason;  // when and why it was accepted; empty when not known
  double smallest_percent = 0.0;
  std::vector<StudyVerdict> studies;
  std::vector<ComparedCell> cells;    // that are not identical
  std::vector<GateFinding> findings;  // alarms first
  std::uint64_t looked_at = 0;        // cells and numbers that were compared
  std::vector<std::string> notes;
  Verdict verdict() const;
  std::uint64_t alarms() const;
};

// What somebody reads in the morning: a verdict, then each alarm in a few lines, then what is better or to be
// known. Ends with a newline.
std::string morning_text(const GateReport& report);

// Every compared cell of the methods whose name is `method`, as a plain table.
std::string cell_table(const GateReport& report, const std::string& method);

Json gate_json(const GateReport& report);

// "2 participants in table3": what was not judged and why; empty when all was.
std::string not_judged_text(const GateReport& report);

// JUnit XML as CI services read it: one test case a study and one a finding that is an alarm. A study that
// was not judged is skipped, with the reason.
std::string gate_junit(const GateReport& report);
// Of a gate that could not be done: one test case that is an error, with the message.
std::string gate_junit_of_error(const std::string& time, const std::string& message);

// Text that a shell takes as one word: as it is when that is plain, else in single quotes.
std::string shell_word(const std::string& text);

}  // namespace trilat
