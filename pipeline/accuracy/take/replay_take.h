// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "datasets/results/replay.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

// Whether this is the first take of its condition that can be evaluated, as far as the plan knows.
bool is_replayed(const Plan& plan, std::size_t take);

// The first part of a take as every sensor sees it, in the world.
ReplayTake replay_of(const Plan& plan, std::size_t take, const TakeData& data);

}  // namespace trilat
