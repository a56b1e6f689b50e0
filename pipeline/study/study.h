// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "datasets/base/json.h"
#include "pipeline/study/run_control.h"

namespace trilat {

inline constexpr std::uint64_t kMaxShards = 100'000;

// The share of a study's items that this process computes.
struct Shard {
  std::uint64_t number = 1;
  std::uint64_t of = 0;  // 0: all of them, and the summary
  bool whole() const { return of == 0; }
  bool operator==(const Shard&) const = default;
};

// Reads "3/7". InputError at `place` when it is not k/n with 1 <= k <= n.
Shard parse_shard(const std::string& text, const std::string& place);

std::string name_of(const Shard& shard);  // "3/7"

// The shard of each item, from 1 to `shards` (0 counts as 1): the dearest goes first, each to the shard that
// has least so far. Equal costs give equal shares on every machine. No shard has more than 4/3 of what the
// best division would give it (Graham 1969).
std::vector<std::uint64_t> shards_of(std::span<const double> costs, std::uint64_t shards);

// A hash of all that decides an outcome, the build of this program included.
std::string key_of(const Json& settings);

// The outcome of an item and the folder of its files.
struct ItemResult {
  std::string key;
  std::filesystem::path folder;  // no such folder when it failed
  Json json;
  bool failed = false;
  JsonPlace place() const { return JsonPlace(folder / "item.json").at("outcome"); }
};
using Outcomes = std::map<std::string, ItemResult>;  // by the item's id

// The result of computing an item.
struct ComputedItem {
  ComputedItem(Json json, bool has_failed = false) : outcome(std::move(json)), failed(has_failed) {}
  Json outcome;
  bool failed;  // it is named in the results, and tried again by the next run
};

// The entries of a manifest that all studies have: the resolved study and its hash; then `more`.
Json manifest_of(const Json& resolved, const Json& more);

struct StudyOptions {
  std::function<bool()> stop_requested = {};
  std::function<void(const std::string& stage, double share)> progress = {};  // from any thread
  Shard shard = {};
  bool fresh = false;               // items that are there are computed again
  std::function<void()> mark = {};  // marks the output as its verb's, before anything is written into it
};

// RunControl of one stage of a run; `options` must outlive it.
RunControl control_of(const StudyOptions& options, const std::string& stage);

// The ids of the items of one run, by what the run did with them.
struct ItemCounts {
  std::vector<std::string> computed, found;  // in the order in which they came
  std::map<std::string, Json> failed;        // their outcomes
  std::vector<std::string> damaged;          // what is wrong with items that were there
  bool unchanged = false;                    // the results were there already
  std::size_t all() const { return computed.size() + found.size() + failed.size(); }
};

// Calls work(threads) on so many threads; 0: as many as there are processors.
void on_threads(int threads, const std::function<void(int)>& work);

// run.json: what may differ between equal runs: the machine, the number of threads, the times; `more`: what
// else it says. What the results are marked by stays in it.
void write_run_record(const std::filesystem::path& folder, const std::filesystem::path& results,
                      const Json& more, double wall_s, int threads);

// Name of the processor as this machine calls it, or "unknown".
std::string processor_name();

}  // namespace trilat
