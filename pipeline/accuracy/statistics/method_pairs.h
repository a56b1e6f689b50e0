// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/results/samples.h"
#include "pipeline/accuracy/statistics/aligned_errors.h"

namespace trilat {

// The mean error of each method (row) over the samples that each other one (column) answers too, both aligned
// on these; of a method with itself over all its answers. In metres, the mean of the joint groups, of the
// takes of one condition; NaN where a group has no such sample. One such table behind the other for each
// alignment of the layout.
std::vector<double> paired_errors_m(const SamplesFile& samples, const std::string& condition,
                                    StatisticsLayout layout);

}  // namespace trilat
