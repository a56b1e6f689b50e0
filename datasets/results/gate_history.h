// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/results/results_file.h"

namespace trilat {

// One line of a history: what a gate saw in one night, or that a change was accepted.
struct HistoryEntry {
  std::string time;  // UTC, ISO 8601
  std::string program;
  bool accepted = false;  // these results became the baseline: whatever changed is meant to be so
  std::string reason;     // of an acceptance
  bool quiet = true;
  std::vector<std::string> alarms;        // what each was about, one name a thing
  std::vector<std::string> not_judged;    // studies of which nobody can say whether they are worse
  std::map<std::string, double> error_m;  // mean absolute error by cell
  std::map<std::string, double> coverage;

  TRILAT_FIELDS(time, program, accepted, reason, quiet, alarms, not_judged, error_m, coverage)
};

struct History {
  std::vector<HistoryEntry> entries;  // oldest first
  std::string torn;                   // which line was torn and left out; empty when none was
};

// history.jsonl (trilat.history, version 2): one JSON document a line. A last line that is torn is left out
// and told; any other line that cannot be read is an InputError with its number. Empty when there is no file.
History read_history(const std::filesystem::path& path);

// Adds one line. The file is written aside and put in place: it never shows half a line, and one that was
// torn is gone.
void append_history(const std::filesystem::path& path, const HistoryEntry& entry);

// Why a baseline is what it is: accepted.json in its folder.
struct AcceptedBaseline {
  static constexpr const char *kFile = "accepted.json", *kFormat = "trilat.accepted";
  std::string reason;
  std::string time;             // UTC, ISO 8601
  std::string program;          // that accepted it
  std::string sha256;           // of its results: names and contents of their files
  std::string replaces_sha256;  // of the baseline before; empty: there was none
  std::string replaces_time;    // when that one had been accepted; empty when not known

  TRILAT_FIELDS(reason, time, program, sha256, replaces_sha256, replaces_time)
};

}  // namespace trilat
