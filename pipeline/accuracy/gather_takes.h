// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_result.h"
#include "pipeline/study/watch.h"

namespace trilat {

// Gathers the samples of all takes of the plan into one file, summarises them and writes samples.h5,
// summary.json, tracking.json and replay.h5 into `results`. The bytes depend on nothing but the plan and the
// takes, whose summaries are taken. InputError when the samples of a take are not where they should be.
void gather_takes(const Plan& plan, std::span<EvaluatedTake> takes, bool cross_check,
                  const std::filesystem::path& results, const Watch& watch);

}  // namespace trilat
