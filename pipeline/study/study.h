// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/results/items.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/watch.h"

namespace trilat {

// Which share of a work this process does.
struct Shard {
  std::uint64_t number = 1;
  std::uint64_t of = 0;  // 0: the work is not divided; 1: it is, into one part
  bool whole() const { return of == 0; }
  bool operator==(const Shard&) const = default;
};

// "3/7"; InputError at `place` when it is not k/n with 1 <= k <= n.
Shard parse_shard(const std::string& text, const std::string& place);

std::string name_of(const Shard& shard);  // "3/7"

// Whose each item is, from 1 to `shards` (0 counts as 1): the dearest goes first, each to the shard that has
// least so far. Equal costs give equal shares on every machine. No shard has more than 4/3 of what the best
// division would give it (Graham 1969).
std::vector<std::uint64_t> shards_of(std::span<const double> costs, std::uint64_t shards);

// A hash of all that decides an outcome, the build of this program included.
std::string key_of(const Json& settings);

// What an item gave and where its files are: in a folder of its own, or, from earlier results that gathered
// them, in that of the results.
struct Outcome {
  std::string key;  // empty: the item failed
  std::filesystem::path folder;
  std::optional<Json> gathered;  // the outcome, where the item has no folder of its own

  Json json() const;
  std::string place() const;  // for errors
};
using Outcomes = std::map<std::string, Outcome>;  // by the item's id

// What computing an item gives.
struct Computed {
  Computed(Json json, bool has_failed = false) : outcome(std::move(json)), failed(has_failed) {}
  Json outcome;
  bool failed;  // it is told in the results, and tried again by the next run
};

// What is computed, kept and taken from earlier results as one piece.
struct Item {
  // Plain names with '/' between them. Items of equal first name are computed beside each other, other names
  // one after the other; the first name is what progress is told of.
  std::string id;
  double cost;  // estimated, in any unit that all items share
  // `into`: an empty folder; files that are left in it belong to the item. From any thread.
  std::function<Computed(const std::filesystem::path& into, const Watch& watch)> compute;
  // Of all that decides the outcome, where that is not Study::work; empty when it cannot be known. From any
  // thread.
  std::function<std::string(const Watch& watch)> key = {};
};

// A study as a value: what it consists of, and how its items are put together. run_study() does the rest and
// knows no kind.
struct Study {
  std::string kind;
  // All that putting together needs, and every item without a key of its own depends on; equal in all shards.
  Json work;
  std::vector<Item> items = {};
  // Writes what depends on no item, as simulator.json. A part has it, too.
  std::function<void(const std::filesystem::path& folder)> write_beside = {};
  // Measures what depends on the machine and on no item, and writes it beside, as timings.json.
  std::function<void(const std::filesystem::path& folder, const Watch& watch)> time = {};
  // Writes the summary of all items.
  std::function<void(const Outcomes& outcomes, const std::filesystem::path& results, const Watch& watch)>
      reduce;
  // What manifest.json says besides format and program. Without one the output is no results folder: it keeps
  // no record of its items.
  std::function<Json(const Outcomes& outcomes)> manifest = {};

  // Files of the results into which reduce() gathers those of the items: earlier results without them give no
  // items, and to a part they give none either.
  std::vector<std::string> gathers = {};
  // Where the key of all results depends on more than `work`: asked when all items are done.
  std::function<std::string()> key = {};
  std::shared_ptr<HashCache> hashes = {};  // kept with the output, where there is one
  std::function<Json()> times = {};        // that run.json lists beside its own
};

// The entries of a manifest that all studies have: the resolved study and its hash; then `more`.
Json manifest_of(const Json& resolved, const Json& more);
// Of a study that is simulated from its settings alone.
Json manifest_of_generated(const Json& resolved);

struct StudyOptions {
  int threads = 0;  // 0: as many as there are processors
  std::function<bool()> stop_requested = {};
  std::function<void(const std::string& stage, double share)> progress = {};  // from any thread
  Shard shard = {};                                                           // all of it, or a part
  std::vector<std::filesystem::path> reuse = {};  // earlier outputs, asked in this order
  bool fresh = false;                             // what `output`.partial holds is not gone on with
};

// What became of the items that a run was asked for: their ids, in the order in which they came. Those that
// failed are left out.
struct ItemTally {
  std::vector<std::string> computed, continued, reused;
  bool unchanged = false;  // the output held just these results and was left alone
  std::size_t all() const { return computed.size() + continued.size() + reused.size(); }
};

// Whether `output` holds finished results of that key, with all their files.
bool holds_results(const std::filesystem::path& output, const std::string& key);

// Computes the items that are this run's and not known from the same run before it was stopped or from
// earlier outputs, and writes the results folder: manifest.json, what reduce(), write_beside() and time()
// write, items.json and run.json; a shard writes a part folder: part.json, its items, and what is beside
// them. All is written aside and put in place at the end. Nothing is written when `output` is among the
// earlier outputs and holds just these results. Throws Interrupted when asked to stop; the items that are
// done stay in `output`.partial, and the same run goes on from there.
ItemTally run_study(const Study& study, const std::filesystem::path& output, const StudyOptions& options);

// All items of parts that belong together, as read_parts() gives them. InputError when one is not there or
// not whole.
Outcomes outcomes_of(std::span<const FoundPart> parts);

// The results that one run would have given, to the byte, but for run.json and timings.json. Nothing is
// computed.
void merge_parts(const Study& study, std::span<const FoundPart> parts, const std::filesystem::path& output,
                 const StudyOptions& options);

}  // namespace trilat
