// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"
#include "pipeline/cli/kinds.h"
#include "pipeline/study/study.h"

namespace trilat {

// Refuses an output that is missing or may not be written; `inputs`: what the study reads beside what the
// arguments name.
void check_run_output(const RunArguments& arguments, StudyKind kind,
                      std::vector<std::filesystem::path> inputs = {});

// The earlier results that a run may take from: those named, and what its output holds unless it is to be
// computed afresh.
std::vector<std::filesystem::path> reused_results(const RunArguments& arguments);

// Says what became of a shard, on stdout.
void print_part(const std::filesystem::path& output, const Shard& shard, const ItemTally& tally, bool json);

// items, items_computed, items_continued, items_reused.
Json tally_json(const ItemTally& tally);

// On stderr, what was not computed, when there was such; `items`: what they are called.
void tell_reuse(const std::string& items, const ItemTally& tally);

// On stderr, what a run that was stopped has left where.
void tell_interrupted(const std::filesystem::path& folder);

}  // namespace trilat
