// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "datasets/base/strict_json.h"
#include "pipeline/plan.h"
#include "pipeline/runner.h"

namespace trilat {

// manifest.json: what went into these results, equal for equal inputs: the resolved study and its hash, the
// SHA-256 of every input file, program version, rig, counts. Files that cannot be read are listed without a
// hash.
void write_manifest(const std::filesystem::path& folder, const Plan& plan,
                    std::span<const EvaluatedTake> evaluated);

// run.json: what may differ between equal runs: the machine, the number of threads, the times.
// `takes`: what was computed and what was not; null where that makes no sense.
void write_run_record(const std::filesystem::path& folder, const StageTimes& times, double wall_s,
                      int threads, const ItemTally* takes);
void write_run_record(const std::filesystem::path& folder, const Json& times, double wall_s, int threads);

// As this machine calls it, or "unknown".
std::string processor_name();

}  // namespace trilat
