// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "datasets/results/summary.h"
#include "datasets/take/campaign.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/study/study.h"

namespace trilat {

// The key of the finished results, which is known before the takes are planned. Reads what `hashes` does not
// know. Interrupted when asked to stop.
std::string key_of_results(const StudySpec& spec, const Campaign& campaign, bool cross_check,
                           HashCache& hashes, const Watch& watch);

// Takes of a campaign through every method; an item is a take. A take that cannot be evaluated fails, the
// others go on. Its summary.json is a ResultsSummary. InputError when the study has no method that could be
// cross-checked, and as make_plan(). `unreadable`: why takes cannot be evaluated, as far as the plan knows.
Study accuracy_study(const StudySpec& spec, const Campaign& campaign, bool cross_check,
                     const std::shared_ptr<HashCache>& hashes, const Watch& watch,
                     std::vector<TakeNote>* unreadable = nullptr);
// To put parts together: needs them only, not the campaign. InputError when `work` is not what they share.
Study accuracy_of_parts(const Json& work, const std::string& place);

// About how long a take takes, in instants.
double cost_of(const PlannedTake& take);

// What is to be said of the takes of a part.
struct PartNotes {
  std::size_t takes = 0;
  std::vector<TakeNote> notes;
};
PartNotes notes_of_part(const std::filesystem::path& part);

// Plans and runs a study on all or one shard of its takes, unless `output` is to be reused and holds just
// these results.
struct ExecuteOptions {
  int threads = 0;  // 0: as many as there are processors
  bool cross_check = false;
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};
  std::vector<std::filesystem::path> reuse = {};  // earlier results, asked in this order for takes
  bool fresh = false;                             // what `output`.partial holds is not gone on with
  Shard shard = {};
};
ItemTally run_accuracy(const StudySpec& spec, const Campaign& campaign, const std::filesystem::path& output,
                       const ExecuteOptions& options);
// All of it; its summary.
ResultsSummary execute_study(const StudySpec& spec, const Campaign& campaign,
                             const std::filesystem::path& output, const ExecuteOptions& options);

}  // namespace trilat
