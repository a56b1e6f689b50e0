// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "datasets/results/summary.h"

namespace trilat {

// What changed from one accuracy result to another, for the conditions, methods and groups of both and the
// average of the groups, under their first alignment: Student's t between participants, of the differences of
// each where both have the same. Nothing where alignment or truth differ: those are two measures.
std::optional<ErrorChanges> changes_between(const ResultsSummary& before, const ResultsSummary& after);

// The same of two results folders, on average over the groups. Nothing for other kinds, for more or fewer
// than two, or where alignment or truth differ: those are two measures.
std::optional<ErrorChanges> changes_between(const std::vector<std::filesystem::path>& results);

}  // namespace trilat
