// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "datasets/base/document.h"

namespace trilat {

// Verdict of the gate on a night. A regression that was found counts, whatever was not judged beside it.
enum class NightVerdict : std::uint8_t {
  quiet,
  regression,
  not_judged,  // other recordings of too few participants to tell a change from chance
  accepted,    // its results became the baseline: whatever changed is meant to be so
};
inline constexpr std::array kNightVerdicts{"quiet", "regression", "not_judged", "accepted"};
const char* name_of(NightVerdict verdict);

// One night, or an accepted change.
struct Night {
  std::string time;  // UTC, ISO 8601
  std::string program;
  NightVerdict verdict = NightVerdict::quiet;
  std::string reason = {};                          // of an acceptance
  std::vector<std::string> alarms = {};             // what each is about, by one name every night
  std::vector<std::string> not_judged = {};         // studies
  std::map<std::string, double> mean_error_m = {};  // by column, as "table3: nonlinear, walking (m)"
};

// history.csv, oldest night first: time, program, verdict, reason, alarms and not_judged (separated by "; "),
// then a column for each mean error. Empty when there is no file. InputError with the line where a row is
// cut or cannot be read, or where the file is a history of version 0.4.0 (JSON).
std::vector<Night> read_history(const std::filesystem::path& path);
// Adds one line, and a column for each new mean error. The file is replaced whole.
void add_to_history(const std::filesystem::path& path, const Night& night);
// How a history begins.
inline constexpr const char* kHistoryHeader = "time,program,verdict,reason,alarms,not_judged";

// Why a baseline is what it is: accepted.json in its folder.
struct AcceptedBaseline {
  static constexpr const char* kFile = "accepted.json";
  std::string reason;
  std::string time;             // UTC, ISO 8601
  std::string program;          // that accepted it
  std::string sha256;           // of its results: names and contents of their files
  std::string replaces_sha256;  // of the baseline before; empty: there was none
  std::string replaces_time;    // when that one had been accepted; empty when not known

  static void fields(auto& self, auto&& f) {
    f.format("trilat.accepted");
    f("reason", self.reason, "time", self.time, "program", self.program, "sha256", self.sha256,
      "replaces_sha256", self.replaces_sha256, "replaces_time", self.replaces_time);
  }
};

}  // namespace trilat
