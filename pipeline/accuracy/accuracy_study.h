// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/results/summary.h"
#include "datasets/rig/campaign.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/study/study.h"

namespace trilat {

struct AccuracyStudy {
  StudySpec study;
  Campaign campaign;
  bool cross_check = false;
};

// Takes of a campaign through every method into a folder of results; an item is a take. A take that cannot be
// evaluated fails, the others go on. On the threads of the caller. InputError where the study has no method
// that could be cross-checked, and as make_plan() and ResultsRun.
ItemCounts run_accuracy(const AccuracyStudy& asked, const std::filesystem::path& folder,
                        const StudyOptions& options);

// About how long a take takes, in instants.
double cost_of(const PlannedTake& take);

// The notes of takes that failed.
std::vector<TakeNote> notes_of(const ItemCounts& tally);

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
