// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/results/declared_parameters.h"
#include "datasets/results/results_file.h"
#include "datasets/results/stage_timings.h"
#include "pipeline/items/study_items.h"
#include "pipeline/watch.h"

namespace trilat {

// What an item gave, and where that stands, for errors.
struct Outcome {
  Json json;
  std::string place;
};
using Outcomes = std::map<std::string, Outcome>;  // by the item's id

// What is computed, kept and taken from earlier results as one piece.
struct Item {
  // Plain names with '/' between them. Items of equal first name are computed beside each other, other names
  // one after the other; the first name is what progress is told of.
  std::string id;
  double cost;  // estimated, in any unit that all items share
  // `scratch`: a folder for files that are removed before it returns. From any thread.
  std::function<Json(const std::filesystem::path& scratch, const Watch& watch)> compute;
};

// A study as a value: what it consists of, and how its items are put together. run_study() does the rest and
// knows no kind.
struct Study {
  StudyKind kind;
  // All that every item depends on and putting together needs; equal in all shards.
  Json work;
  std::vector<Item> items;
  Json manifest;                              // what manifest.json says beside format and program
  std::vector<DeclaredParameter> parameters;  // simulator.json, when there are some
  // Writes the summary of all items into `results`.
  std::function<void(const Outcomes& outcomes, const std::filesystem::path& results, const Watch& watch)>
      reduce;
  // Measures what depends on the machine and not on items: timings.json. Empty: nothing does.
  std::function<StageTimings(const std::filesystem::path& scratch, const Watch& watch)> time = {};
};

// The entries of a manifest that every kind has: the resolved study and its hash.
Json manifest_of(const Json& resolved, const Json& more);

struct StudyOptions {
  int threads = 0;  // 0: as many as there are processors
  std::function<bool()> stop_requested = {};
  std::function<void(const std::string& stage, double share)> progress = {};  // from any thread
  WorkOptions work = {};
  bool fresh = false;  // what `output`.partial holds is not gone on with
};

// Computes the items that are this run's and not known from the same run before it was stopped or from
// earlier outputs, and writes the results folder: manifest.json, simulator.json, what reduce() writes,
// timings.json, items.json and run.json; a shard writes a part folder. All is written aside and put in place
// at the end. Nothing is written when `output` is among the earlier results and holds just these. Throws
// Interrupted when asked to stop; the items that are done stay in `output`.partial, and the same run goes on
// from there.
ItemTally run_study(const Study& study, const std::filesystem::path& output, const StudyOptions& options);

// The results that one run would have given, to the byte, but for run.json and timings.json. Nothing is
// computed. InputError when an item is not there.
void merge_parts(const Study& study, std::span<const FoundPart> parts, const std::filesystem::path& output,
                 const StudyOptions& options);

}  // namespace trilat
