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

#include "datasets/results/item_store.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/watch.h"

namespace trilat {

inline constexpr std::uint64_t kMostShards = 100'000;

// The share of a study's items that this process computes.
struct Shard {
  std::uint64_t number = 1;
  std::uint64_t of = 0;  // 0: all of them, and the summary
  bool whole() const { return of == 0; }
  bool operator==(const Shard&) const = default;
};

// "3/7"; InputError at `place` when it is not k/n with 1 <= k <= n.
Shard parse_shard(const std::string& text, const std::string& place);

std::string name_of(const Shard& shard);  // "3/7"

// The shard of each item, from 1 to `shards` (0 counts as 1): the dearest goes first, each to the shard that
// has least so far. Equal costs give equal shares on every machine. No shard has more than 4/3 of what the
// best division would give it (Graham 1969).
std::vector<std::uint64_t> shards_of(std::span<const double> costs, std::uint64_t shards);

// A hash of all that decides an outcome, the build of this program included.
std::string key_of(const Json& settings);

// The outcome of an item and the folder of its files.
struct Outcome {
  std::string key;
  std::filesystem::path folder;  // no such folder when it failed
  Json json;
  bool failed = false;
  std::string place() const { return (folder / "item.json").string() + " outcome"; }  // for errors
};
using Outcomes = std::map<std::string, Outcome>;  // by the item's id

// The result of computing an item.
struct Computed {
  Computed(Json json, bool has_failed = false) : outcome(std::move(json)), failed(has_failed) {}
  Json outcome;
  bool failed;  // it is named in the results, and tried again by the next run
};

// One piece of work: it is computed, stored and found as a whole.
struct Item {
  // Plain names with '/' between them. Items of equal first name are computed beside each other, other names
  // one after the other; the first name is shown with the progress.
  std::string id;
  double cost;  // estimated, in any unit that all items share
  // `into`: an empty folder; files that are left in it belong to the item. From any thread.
  std::function<Computed(const std::filesystem::path& into, const Watch& watch)> compute;
  // Gives the hash of everything that decides the outcome, where Study::settings alone do not; empty when an
  // input cannot be read. From any thread.
  std::function<std::string(const Watch& watch)> key = {};
};

// A study as a value: what it consists of, and how its items are put together. run_study() does the rest and
// knows no kind.
struct Study {
  std::string kind;
  Json settings;  // every item without a key of its own depends on them
  std::vector<Item> items = {};
  // Writes what depends on no item, as simulator.json.
  std::function<void(const std::filesystem::path& folder)> write_beside = {};
  // Measures what depends on the machine and on no item, and writes it beside, as timings.json.
  std::function<void(const std::filesystem::path& folder, const Watch& watch)> time = {};
  // Writes into an empty folder what is then moved into the results; summary.json says that they are whole.
  std::function<void(const Outcomes& outcomes, const std::filesystem::path& folder, const Watch& watch)>
      reduce;
  // Gives the entries of manifest.json besides format, program and items. Called when this run's keys are
  // known.
  std::function<Json()> manifest = {};
  std::shared_ptr<HashCache> hashes = {};  // kept with the results, where there is one
};

// The entries of a manifest that all studies have: the resolved study and its hash; then `more`.
Json manifest_of(const Json& resolved, const Json& more);
// The manifest of a study that is simulated from its settings alone.
Json manifest_of_generated(const Json& resolved);

struct StudyOptions {
  int threads = 0;  // 0: as many as there are processors
  std::function<bool()> stop_requested = {};
  std::function<void(const std::string& stage, double share)> progress = {};  // from any thread
  Shard shard = {};
  bool fresh = false;               // items that are there are computed again
  std::function<void()> mark = {};  // marks the output as its verb's, before anything is written into it
};

// Watch of one stage of a run; `options` must outlive it.
Watch watch_of(const StudyOptions& options, const std::string& stage);

// The ids of the items of one run, by what the run did with them.
struct ItemTally {
  std::vector<std::string> computed, found;  // in the order in which they came
  std::map<std::string, Json> failed;        // their outcomes
  std::vector<std::string> damaged;          // what is wrong with items that were there
  bool unchanged = false;                    // the results were there already
  std::size_t all() const { return computed.size() + found.size() + failed.size(); }
};

// Computes the items of the shard that `results` does not have yet. A run of all of them then puts them
// together: manifest.json, what reduce(), write_beside() and time() write, and run.json; items that are none
// of the study's are removed. Results are finished when summary.json is there, which comes last and goes
// first. Nothing is written where the same results are finished already. InputError when another run of all
// items fills the folder. Throws Interrupted when asked to stop; the same run goes on from the items that are
// done.
ItemTally run_study(const Study& study, const std::filesystem::path& results, const StudyOptions& options);

// Computes the items as run_study() does, for a study that makes recordings and no summary: reduce() may move
// them into `folder`, from where they go into `output`. `mark` is the file that says that the output is
// whole; what `is_earlier` is replaced. No items are kept.
ItemTally run_to_files(const Study& study, const std::filesystem::path& output, const StudyOptions& options,
                       const std::string& mark,
                       const std::function<bool(const std::filesystem::path&)>& is_earlier);

}  // namespace trilat
