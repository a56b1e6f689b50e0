// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>

#include "datasets/results/summary.h"
#include "datasets/take/campaign.h"
#include "pipeline/memory_budget.h"
#include "pipeline/study_spec.h"

namespace trilat {

struct ExecuteOptions {
  int threads = 0;  // 0: as many as there are processors
  bool cross_check = false;
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};
  std::uint64_t memory_bytes = half_of_memory_bytes();
};

// Plans and runs a study and writes the results folder: manifest.json, summary.json, samples.h5,
// gdop_map.json, replay.h5, run.json. All is written beside and put in place at the end; an older results
// folder of that name is replaced, any other folder is refused. Interrupted leaves what was computed in
// `output`.partial.
ResultsSummary execute_study(const StudySpec& study, const Campaign& campaign,
                             const std::filesystem::path& output, const ExecuteOptions& options);

}  // namespace trilat
