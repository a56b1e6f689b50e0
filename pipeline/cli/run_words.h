// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "datasets/base/json.h"
#include "pipeline/study/study.h"

namespace trilat {

// items, items_computed, items_found, items_failed, unchanged.
Json tally_json(const ItemCounts& tally);

// On stderr, what was not computed and what had to be computed again, when there was such; `items`: what they
// are called.
void print_item_counts(const std::string& items, const ItemCounts& tally);

// On stderr, what a run that was stopped has left where.
void tell_interrupted(const std::filesystem::path& folder);

}  // namespace trilat
