// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/results/declared_parameters.h"
#include "pipeline/accuracy/plan.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/watch.h"

namespace trilat {

// What putting takes together needs to know of the plan of a study: the `work` that its parts share.
Json planned_work(const Plan& plan, bool cross_check, HashCache& hashes, const Watch& watch);

// A plan that can be summarised, not run: it does not know the files of its takes.
struct PlannedWork {
  Plan plan;
  bool cross_check = false;
  std::vector<DeclaredParameter> parameters;
};
// InputError at `place` when the document is not as planned_work() writes it.
PlannedWork read_planned_work(const Json& work, const std::string& place);

}  // namespace trilat
