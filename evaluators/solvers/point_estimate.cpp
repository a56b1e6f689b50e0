// SPDX-License-Identifier: MIT
#include "evaluators/solvers/point_estimate.h"

#include <array>

namespace trilat {
namespace {

constexpr std::array<std::string_view, kSolveStatusCount> kNames{
    "not_solved",       "converged",      "closed_form",    "clamped",          "iteration_limit",
    "mirror_ambiguous", "rank_deficient", "too_few_ranges", "non_finite_input", "invalid_input",
    "diverged",         "no_observation", "given"};

}  // namespace

const std::vector<std::string>& solve_status_names() {
  static const std::vector<std::string> names(kNames.begin(), kNames.end());
  return names;
}

std::string_view name_of(SolveStatus status) { return kNames.at(static_cast<std::size_t>(status)); }

}  // namespace trilat
