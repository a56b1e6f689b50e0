// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "datasets/results/summary.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_result.h"
#include "pipeline/study/watch.h"

namespace trilat {

// All cells of a study: condition x group x method x alignment. A take that this process evaluated has its
// summary, which is taken; of the others it is made from their samples, and where these have the errors of
// another alignment than the study's first their item is replaced. Sums are taken in the order of the takes,
// whatever the threads. Memory holds of each answered sample its distances alone, 8 bytes an alignment and
// set, for their quantiles. Throws Interrupted.
ResultsSummary summarise(const Plan& plan, const RunOutcome& outcome, std::span<EvaluatedTake> takes,
                         const Watch& watch);

}  // namespace trilat
