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
// summary.json, tracking.json and replay.h5 into `results`. The bytes
// depend on nothing but the plan and the takes. InputError when the samples of a take are not where they
// should be.
void gather_takes(const Plan& plan, std::span<const EvaluatedTake> takes, bool cross_check,
                  const std::filesystem::path& results, const Watch& watch);

// Whether results that gathered their takes have all files that the take is part of.
bool holds_take(const Plan& plan, std::size_t take, const std::filesystem::path& results);

// Copies the samples of one take, and its replay where it has one, from results that gathered them.
void take_out(const Plan& plan, std::size_t take, const std::filesystem::path& results,
              const std::filesystem::path& into);

}  // namespace trilat
