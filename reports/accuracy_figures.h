// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/results/summary.h"
#include "reports/figure.h"

namespace trilat {

// The methods that figures of a study show, in the order of the study: the paper's three, the plain mean, the
// best answer of all and, of a study without any of these, its first ones.
std::vector<std::string> methods_worth_a_figure(const ResultsSummary& summary);

// Errors of each joint group as boxes (quartiles and median; whiskers from the 5th to the 95th percentile)
// with the mean and its interval, one figure a condition, in the study's first alignment.
std::vector<Figure> error_box_figures(const ResultsSummary& summary);

}  // namespace trilat
