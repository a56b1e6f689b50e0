// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "pipeline/sweep/sweep_study.h"
#include "pipeline/sweep/sweep_summary.h"
#include "tests/pipeline/sweeps.h"
#include "tests/support/scratch.h"

namespace trilat {

struct SweepRun {
  ItemTally tally;
  SweepSummary summary;
};

inline SweepRun sweep_into(const std::filesystem::path& output, const SweepPlan& plan,
                           const StudyOptions& options = {}) {
  SweepRun run{run_study(sweep_study(plan), output, options), {}};
  if (options.shard.whole()) run.summary = read_results<SweepSummary>(output);
  return run;
}

inline SweepSummary swept(const SweepPlan& plan) {
  const ScratchFolder folder;
  return sweep_into(folder / "results", plan).summary;
}

}  // namespace trilat
