// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "datasets/results/changes.h"

namespace trilat {

// What changed from the first of two accuracy results to the second, for the conditions, groups and methods
// of both, under the first alignment of each. Nothing for other kinds, or for more or fewer than two.
std::optional<ErrorChanges> changes_between(const std::vector<std::filesystem::path>& results);

}  // namespace trilat
