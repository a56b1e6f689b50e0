// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/sweep/execute_sweep.h"

namespace trilat {

// What a sweep, or a shard of it, would compute; on stdout. Gives the exit code.
int print_sweep_plan(const SweepPlan& plan, const Shard& shard, bool json);

// What it found; on stdout.
void print_sweep(const SweepOutcome& outcome, const Shard& shard, bool json);

// Where its cells came from, if not all were computed, and that it was interrupted; on stderr.
void note_sweep_tally(const SweepOutcome& outcome);

}  // namespace trilat
