// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/results/declared_parameters.h"
#include "datasets/results/gdop_map.h"
#include "datasets/results/item_journal.h"
#include "datasets/results/summary.h"
#include "pipeline/memory_budget.h"
#include "pipeline/plan.h"
#include "pipeline/runner.h"

namespace trilat {

// What a results folder is made of: the plan, and every take of it evaluated, here, in another shard or in an
// earlier run.
struct RunParts {
  const Plan& plan;
  std::vector<EvaluatedTake> takes;  // of the plan
  bool cross_check = false;
  std::vector<DeclaredParameter> parameters;
  std::optional<GdopMap> gdop;
  std::string summary_key = {};  // that the takes' own summaries were made with; empty: they have none
};

struct AssembleOptions {
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};
  std::uint64_t memory_bytes = half_of_memory_bytes();
};

// Gathers the samples of all takes into one file, summarises them and writes all of a results folder but
// run.json into `folder`. Memory does not grow with the takes. The bytes depend on nothing but the parts.
// InputError when the samples of a take are not where they should be.
ResultsSummary assemble(const RunParts& parts, const std::filesystem::path& folder, StageTimes& times,
                        const AssembleOptions& options);

struct SummariseHooks {
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};
};

// Summarises takes that are in folders of their own below `folder`, each into a file beside its samples.
void summarise_takes(const Plan& plan, std::span<const std::size_t> takes,
                     const std::filesystem::path& folder, const std::string& key, StageTimes& times,
                     const SummariseHooks& hooks);

// Copies the samples of one take, and its replay where it has one, from one folder to a new one.
void copy_samples(const Plan& plan, std::size_t take, const std::filesystem::path& from,
                  const std::filesystem::path& to);

// The takes as items, in the order of the plan.
std::vector<DoneItem> items_of(const Plan& plan, std::span<const EvaluatedTake> takes);

}  // namespace trilat
