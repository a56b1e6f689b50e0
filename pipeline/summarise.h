// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/results/samples.h"
#include "datasets/results/summary.h"
#include "pipeline/plan.h"
#include "pipeline/runner.h"

namespace trilat {

// Aligns every take's estimates, writes the error column of samples.h5 for the study's first alignment, and
// computes all cells: condition x group x method x alignment. Streams the samples, so memory does not grow
// with the takes. Sums are taken in the order of the takes, whatever the threads.
ResultsSummary summarise(const Plan& plan, const RunOutcome& outcome, SamplesFile& samples);

}  // namespace trilat
