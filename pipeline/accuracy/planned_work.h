// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/results/declared_parameters.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_result.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/watch.h"

namespace trilat {

// What putting takes together needs to know of the plan of a study: the `work` that its parts share.
Json planned_work(const Plan& plan, bool cross_check, HashCache& hashes, const Watch& watch);

// A plan that can be summarised, not run: it does not know the files of its takes.
struct PlannedWork {
  Plan plan;
  bool cross_check = false;
  std::vector<DeclaredParameter> parameters;
};
// InputError at `place` when the document is not as planned_work() writes it.
PlannedWork read_planned_work(const Json& work, const std::string& place);

// The files that a take is made of, by what they are.
struct TakeFile {
  const char* role;
  std::filesystem::path path;
};
std::vector<TakeFile> files_of(const Take& take);

// To be asked before the take is planned, and checked when it was evaluated.
WatchedFiles watched_files(const Take& take);

// The files of a take with their hashes. Interrupted when asked to stop.
std::vector<TakeInput> inputs_of(const Take& take, HashCache& hashes,
                                 const std::function<bool()>& stop_requested);

// The key of a take's work item: equal keys, equal samples and equal result. What only the summary needs
// (names, alignments, intervals) is not in it, so that changing it costs no take.
std::string key_of_take(const Plan& plan, std::size_t take, std::span<const TakeInput> inputs,
                        bool cross_check);

// What decides the bytes of a whole results folder.
struct RunIdentity {
  StudySpec study;
  bool cross_check = false;
  std::string campaign;
  bool simulated = false;
  std::vector<DeclaredParameter> parameters;
  std::vector<Take> takes;
  std::vector<std::vector<TakeInput>> inputs;  // by take
};
std::string key_of_run(const RunIdentity& run);

}  // namespace trilat
