// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>

#include "pipeline/sweep/sweep_plan.h"

namespace trilat {

// A cell's name in the plan, for people: its reading, threshold and range.
std::string id_of_cell(const SweepPlan& plan, std::size_t cell);
// Equal for cells of equal outcome, whatever else their studies hold.
std::string key_of_cell(const SweepPlan& plan, std::size_t cell);

}  // namespace trilat
