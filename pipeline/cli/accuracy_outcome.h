// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/results/summary.h"

namespace trilat {

// Text of an accuracy study on a terminal: methods x joint groups, the mean error in cm with half of its
// 95 % interval, at most 100 columns wide, the best method first; who answers less than all; and which
// differences from the reference are real; then the findings and warnings in words, but for the notes on
// takes, which stderr has. Of the study's first alignment.
std::string outcome_text(const ResultsSummary& summary);

}  // namespace trilat
