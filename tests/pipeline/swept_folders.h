// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "pipeline/sweep/sweep_spec.h"
#include "pipeline/sweep/sweep_summary.h"
#include "tests/pipeline/sweeps.h"
#include "tests/support/scratch.h"

namespace trilat {

inline SweepSummary swept(const SweepSpec& spec) {
  const ScratchFolder folder;
  run_sweep(spec, folder / "results", {});
  return read_results<SweepSummary>(folder / "results");
}

}  // namespace trilat
