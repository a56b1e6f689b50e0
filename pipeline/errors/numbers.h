// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/results/summary.h"
#include "pipeline/errors/condition_errors.h"

namespace trilat {

// Where the reference of a summary answers nothing in any take, the first method that does takes its place,
// and a note says so.
void set_reference(const StudyErrors& errors, ResultsSummary& summary);

// The pairs of methods whose errors on common samples are wanted: each with the reference, with those that
// err least in a condition and group, and with `more` methods, where the study has them.
std::vector<MethodPair> pairs_of(const StudyErrors& errors, const ResultsSummary& summary,
                                 std::span<const std::string> more);

// Adds to a summary that names its study's methods, families, conditions, groups, alignments and participants
// all numbers that follow from its takes' errors, in whose order sums are taken, and the best methods;
// `errors` has its names from the same summary, and its takes the errors of pairs_of().
void add_numbers(const StudyErrors& errors, ResultsSummary& summary);

}  // namespace trilat
