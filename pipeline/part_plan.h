// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/base/strict_json.h"
#include "datasets/results/work_part.h"
#include "pipeline/plan.h"

namespace trilat {

// What merging needs to know of the plan of a study: the `work` of its parts. `inputs`: what its files are.
Json part_work(const Plan& plan, bool cross_check, Json inputs);

// A plan that can be summarised, not run: it does not know the files of its takes.
struct PartPlan {
  Plan plan;
  bool cross_check = false;
};

// InputError when the work of the part at `place` is not as part_work writes it.
PartPlan read_part_plan(const WorkPart& part, const std::string& place);

}  // namespace trilat
