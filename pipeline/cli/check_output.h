// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace trilat {

// What a verb writes, and with it how an older one of its own is known.
enum class OutputKind {
  session_table,
  samples_table,
  joint_table,
  trc,
  c3d,
  calibration,
  body_tracker,
  junit,
  history,
  session,  // and all other recordings: no older one is ever replaced
  merged_campaign,
  truth,
  campaign,
  campaign_part,
  results,
  part,
  report,
  reproduction
};

struct PlannedOutput {
  std::filesystem::path path;
  OutputKind kind;
  std::vector<std::filesystem::path> inputs;  // files and folders that the verb reads; empty ones are none
  bool force = false;                         // what others wrote may be replaced
  std::string of = {};             // of a part: its kind; of the truth: the session that it belongs to
  std::string aside = ".partial";  // behind the name while it is unfinished
};

// The one rule for outputs, asked before anything is written. InputError where `path` is an input, a link to
// one, in one or around one; where it is something that this program did not write, unless `force`; where it
// cannot be written at all.
void check_output(const PlannedOutput& output);

}  // namespace trilat
