// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "datasets/results/changes.h"

namespace trilat {

// What changed from the first of two accuracy results to the second, for the conditions, groups and methods
// of both, under their first alignment. Nothing for other kinds, for more or fewer than two, or where
// alignment or truth differ: those are two measures.
std::optional<ErrorChanges> changes_between(const std::vector<std::filesystem::path>& results);

}  // namespace trilat
