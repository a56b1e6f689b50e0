// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

// What the sensors of a take say against its ground truth, however the two worlds lie: another unit, of all
// or of one joint; joints that are exchanged in the mapping, or far from where they should be. Each note has
// its size and the remedy; a sound take has none.
std::vector<TakeNote> check_truth(const Plan& plan, const PlannedTake& planned, const TakeData& data);

}  // namespace trilat
