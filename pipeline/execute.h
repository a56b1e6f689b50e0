// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>

#include "datasets/results/summary.h"
#include "datasets/take/campaign.h"
#include "pipeline/items/item_store.h"
#include "pipeline/memory_budget.h"
#include "pipeline/study_spec.h"

namespace trilat {

struct ExecuteOptions {
  int threads = 0;  // 0: as many as there are processors
  bool cross_check = false;
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};
  std::vector<std::filesystem::path> reuse = {};  // earlier results, asked in this order for takes
  bool fresh = false;                             // what `output`.partial holds is not gone on with
  std::uint64_t memory_bytes = half_of_memory_bytes();
};

struct StudyRun {
  ResultsSummary summary;
  ItemTally takes;
  bool unchanged = false;  // `output` held just these results already, and was not touched
};

// Plans and runs a study and writes the results folder: manifest.json, summary.json, samples.h5, items.json,
// gdop_map.json, replay.h5, run.json, hashes.json. All is written beside and put in place at the end; an
// older results folder of that name is replaced, any other folder is refused. Interrupted leaves what was
// computed in `output`.partial, and the same run goes on from there.
StudyRun run_study(const StudySpec& study, const Campaign& campaign, const std::filesystem::path& output,
                   const ExecuteOptions& options);
// The summary alone.
ResultsSummary execute_study(const StudySpec& study, const Campaign& campaign,
                             const std::filesystem::path& output, const ExecuteOptions& options);

}  // namespace trilat
