// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/take/campaign.h"

namespace trilat {

// What a verb writes, and with it how an older one of its own is known.
enum class OutputKind {
  joint_table,
  trc,
  calibration,
  junit,
  history,
  session,  // and all other recordings: no older one is ever replaced
  truth,
  campaign,
  results,
  report,
  reproduction
};

struct PlannedOutput {
  std::filesystem::path path;
  OutputKind kind;
  std::vector<std::filesystem::path> inputs;  // files and folders that the verb reads; empty ones are none
  bool force = false;                         // what others wrote may be replaced
  std::string of = {};                        // of the truth: the session that it belongs to
  std::string aside = ".partial";             // behind the name while it is unfinished
};

// InputError unless `force` where the folder holds results of another study, by name (empty: not
// looked at), or of another campaign: of another name, without a common take, or with no input of equal
// SHA-256. Changed settings of the same study go on in place. `campaign`: null for a study that has none.
void refuse_other_results(const std::filesystem::path& output, const std::string& study,
                          const Campaign* campaign, bool force);
// The same where a report was made of other studies than those of these results.
void refuse_other_report(const std::filesystem::path& output,
                         const std::vector<std::filesystem::path>& results, bool force);
// The same where a calibration was made of other inputs.
void refuse_other_calibration(const std::filesystem::path& output,
                              const std::vector<std::filesystem::path>& inputs, bool force);
// The same where a folder holds a simulated campaign of another name.
void refuse_other_campaign(const std::filesystem::path& output, const std::string& name, bool force);

// The one rule for outputs, asked before anything is written. InputError where `path` is an input, a link to
// one, in one or around one; where it is something that this program did not write, unless `force`; where it
// cannot be written at all.
void check_output(const PlannedOutput& output);

}  // namespace trilat
