// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/results/summary.h"
#include "pipeline/errors/condition_errors.h"

namespace trilat {

// Adds to a summary that names its study's methods, families, conditions, groups, alignments and participants
// all numbers that follow from its takes' errors, in whose order sums are taken, and the best methods;
// `errors` has its names from the same summary. Where the reference answers nothing in any take, the first
// method that does takes its place, and a note says so.
void add_numbers(const StudyErrors& errors, ResultsSummary& summary);

}  // namespace trilat
