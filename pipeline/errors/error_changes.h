// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/summary.h"

namespace trilat {

// The errors of a study's joints, with the order of its names.
struct ErrorsByJoint {
  std::vector<std::string> conditions, methods, groups;
  std::vector<TakeJointRow> rows;
};
ErrorsByJoint errors_by_joint(const ResultsSummary& summary);

// The participants with errors, in the order of their names: the same people may come in another order of
// takes.
std::vector<std::string> participants_of(const ErrorsByJoint& errors);

// Whether both are errors by the same measure: of one alignment, from one kind of truth.
bool are_comparable(const ResultsSummary& before, const ResultsSummary& after);

// Changes of mean errors for the conditions, methods and groups of both and the average of the groups:
// Student's t between participants, of the differences of each where both have the same. Nothing where both
// have none in common.
std::optional<ErrorChanges> changes_between(const ErrorsByJoint& before, const ErrorsByJoint& after);

// Changes between two results folders, on average over the groups. Nothing for other kinds, for more or fewer
// than two, or where they are not comparable.
std::optional<ErrorChanges> changes_between(const std::vector<std::filesystem::path>& results);

}  // namespace trilat
