// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "pipeline/accuracy/memory_budget.h"
#include "pipeline/budget/budget_spec.h"
#include "pipeline/study/study.h"

namespace trilat {

// A simulated campaign, once for every source of error, evaluated; the campaigns themselves are not kept. An
// item a source of error. Its summary.json is a BudgetSummary.
Study budget_study(const BudgetSpec& spec, std::uint64_t memory_bytes = half_of_memory_bytes());
// The same from what its parts share, to put them together. InputError when that is not what they share.
Study budget_of_parts(const Json& work, const std::string& place);

}  // namespace trilat
