// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/results/summary.h"
#include "pipeline/errors/condition_errors.h"

namespace trilat {

// Adds to a summary that names its study's methods, families, conditions, groups, alignments and participants
// all that follows from its takes' tables, in whose order sums are taken; `errors` has its names from the
// same summary. When the reference answers nothing in any take, the first method that does takes its place,
// and a note says so.
void summarise(const StudyErrors& errors, ResultsSummary& summary);

}  // namespace trilat
