// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "pipeline/gate/finding.h"

namespace trilat {

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

}  // namespace trilat
