// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/summary.h"

namespace trilat {

// The participants of whom there are errors, in the order of their names: the same people may come in another
// order of takes.
std::vector<std::string> participants_of(const ResultsSummary& summary);

// Changes from one accuracy result to another, for the conditions, methods and groups of both and the
// average of the groups, under their first alignment: Student's t between participants, of the differences of
// each where both have the same. Nothing where alignment or truth differ: those are two measures.
std::optional<ErrorChanges> changes_between(const ResultsSummary& before, const ResultsSummary& after);

// The same of two results folders, on average over the groups. Nothing for other kinds, for more or fewer
// than two, or where alignment or truth differ: those are two measures.
std::optional<ErrorChanges> changes_between(const std::vector<std::filesystem::path>& results);

}  // namespace trilat
