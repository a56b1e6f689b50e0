// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/accuracy/take/plan.h"

namespace trilat {

// What evaluating a take holds in memory at most, estimated from its instants, sensors, joints and methods.
// Takes are read whole.
std::uint64_t memory_needed_bytes(const Plan& plan, const PlannedTake& planned);

// Half of what the machine has, or the control group that this process is in.
std::uint64_t half_of_memory_bytes();

// InputError saying what the take needs, where that is more than `limit_bytes`.
void check_memory(const Plan& plan, const PlannedTake& planned, std::uint64_t limit_bytes);

// How many takes may be evaluated at once so that any of them together stay within `limit_bytes`; those that
// never do are not counted. At least 1.
std::size_t takes_at_once(const Plan& plan, std::uint64_t limit_bytes);

}  // namespace trilat
