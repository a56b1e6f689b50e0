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

// Takes of a campaign through every method; an item is a take. A take that cannot be evaluated fails, the
// others go on. Its summary.json is a ResultsSummary. InputError when the study has no method that could be
// cross-checked, and as make_plan().
Study accuracy_study(const StudySpec& spec, const Campaign& campaign, bool cross_check,
                     const std::shared_ptr<HashCache>& hashes, const Watch& watch);

// About how long a take takes, in instants.
double cost_of(const PlannedTake& take);

// The notes of takes that failed.
std::vector<TakeNote> notes_of(const ItemTally& tally);

// Plans and runs a study on all its takes; the summary.
struct ExecuteOptions {
  int threads = 0;  // 0: as many as there are processors
  bool cross_check = false;
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};
};
ResultsSummary execute_study(const StudySpec& spec, const Campaign& campaign,
                             const std::filesystem::path& output, const ExecuteOptions& options);

}  // namespace trilat
