// SPDX-License-Identifier: MIT
#include <algorithm>
#include <atomic>
#include <mutex>
#include <numeric>

#include <tbb/task_arena.h>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "pipeline/study/known_items.h"
#include "pipeline/study/parallel.h"
#include "pipeline/study/results_folder.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAside = "aside";  // where items are made before they are put in place

std::string stage_of(const std::string& id) { return id.substr(0, id.find('/')); }

Watch watch_of(const StudyOptions& options, const std::string& stage) {
  Watch watch{options.stop_requested, {}};
  if (options.progress) watch.progress = [&options, stage](double share) { options.progress(stage, share); };
  return watch;
}

// How far items are that are computed beside each other.
class StageProgress {
 public:
  StageProgress(std::vector<double> costs, Watch watch)
      : watch_(std::move(watch)),
        costs_(std::move(costs)),
        done_(costs_.size()),
        all_(std::accumulate(costs_.begin(), costs_.end(), 0.0)) {}
  // The watch of the item of that index.
  Watch item(std::size_t index) {
    return {watch_.stop_requested, [this, index](double share) { tell(index, share); }};
  }

 private:
  void tell(std::size_t index, double share) {
    const std::lock_guard lock(mutex_);
    sum_ += costs_[index] * (share - done_[index]);
    done_[index] = share;
    watch_.tell(sum_ / all_);
  }

  Watch watch_;
  std::mutex mutex_;
  std::vector<double> costs_, done_;
  double all_, sum_ = 0.0;
};

// A step that visits all of n items, far apart one after the other: what is done early is like what comes,
// and so is the time it takes.
std::size_t step_through(std::size_t n) {
  auto step = static_cast<std::size_t>(0.618 * static_cast<double>(n)) + 1;
  while (std::gcd(step, n) != 1) ++step;
  return step;
}

// The items of this run, found or computed.
class Run {
 public:
  Run(const Study& study, const fs::path& folder, const StudyOptions& options)
      : study_(study),
        folder_(folder),
        options_(options),
        known_(study, folder, options.reuse, options.shard.whole()) {
    std::vector<double> costs;
    for (const Item& item : study.items) costs.push_back(item.cost);
    const std::vector<std::uint64_t> owner = shards_of(costs, options.shard.of);
    for (std::size_t i = 0; i < owner.size(); ++i) {
      list_.push_back({study.items[i].id, costs[i], owner[i]});
      if (owner[i] == options.shard.number) mine_.push_back(i);
    }
  }

  void compute() {
    std::span<const std::size_t> left = mine_;
    while (!left.empty()) {
      const std::string stage = stage_of(study_.items[left[0]].id);
      std::size_t count = 1;
      while (count < left.size() && stage_of(study_.items[left[count]].id) == stage) ++count;
      const RunningTime time;
      compute_stage(left.first(count), watch_of(options_, stage));
      times_[stage + "_s"] = time.seconds();
      left = left.subspan(count);
    }
    fs::remove_all(folder_ / kAside);
  }
  // After the last file of an item was read.
  void check_earlier() const { known_.check_earlier(); }

  const Outcomes& outcomes() const { return outcomes_; }
  const std::vector<PartItem>& list() const { return list_; }
  const ItemTally& tally() const { return tally_; }
  const Json& times() const { return times_; }

 private:
  void compute_stage(std::span<const std::size_t> items, const Watch& watch) {
    std::vector<double> costs;
    for (const std::size_t i : items) costs.push_back(study_.items[i].cost);
    StageProgress progress(std::move(costs), watch);
    std::atomic<std::size_t> next{0};
    const std::size_t step = step_through(items.size());
    parallel_for_index(items.size(), 1, [&](std::size_t) {
      try {
        for (std::size_t n; (n = next++) < items.size();) {
          const std::size_t k = n * step % items.size();
          const Watch of_item = progress.item(k);
          of_item.check();
          take(study_.items[items[k]], of_item);
          of_item.tell(1.0);
        }
      } catch (...) {
        next = items.size();  // nobody begins another
        throw;
      }
    });
  }

  void take(const Item& item, const Watch& watch) {
    const std::string key =
        item.key ? item.key(watch) : trilat::key_of({{"study", study_.work}, {"item", item.id}});
    const fs::path aside = folder_ / kAside / item.id;
    const auto found = known_.find(item.id, key);
    Outcome outcome;
    if (found) {
      outcome = options_.shard.whole() ? found->outcome : known_.bring_here(item.id, found->outcome, aside);
    } else {
      make_folder(aside);
      const Computed computed = item.compute(aside, watch);
      outcome.key = computed.failed ? "" : key;
      put_item(aside, folder_, {item.id, outcome.key, computed.outcome});
      outcome.folder = item_folder(folder_, item.id);
    }
    const std::lock_guard lock(mutex_);
    if (!outcome.key.empty()) {
      std::vector<std::string>& list = !found             ? tally_.computed
                                       : found->continued ? tally_.continued
                                                          : tally_.reused;
      list.push_back(item.id);
    }
    outcomes_[item.id] = std::move(outcome);
  }

  const Study& study_;
  const fs::path& folder_;
  const StudyOptions& options_;
  KnownItems known_;
  std::vector<PartItem> list_;
  std::vector<std::size_t> mine_;
  std::mutex mutex_;
  Outcomes outcomes_;
  ItemTally tally_;
  Json times_ = Json::object();
};

void write_manifest(const Study& study, const Outcomes& outcomes, const fs::path& folder) {
  Json manifest{{"format", "trilat.manifest"}, {"version", 1}, {"program", kProgramVersion}};
  manifest.update(study.manifest(outcomes));
  write_file(folder / "manifest.json", json_text(manifest, 1) + "\n");
}

std::string results_key(const Study& study, const Outcomes& outcomes) {
  const bool failed = std::ranges::any_of(outcomes, [](const auto& o) { return o.second.key.empty(); });
  if (failed) return "";  // what failed may work the next time
  return study.key ? study.key() : key_of(study.work);
}

// All that comes of the items of a study.
void write_results(const Study& study, std::span<const PartItem> list, const Outcomes& outcomes,
                   const fs::path& folder, const StudyOptions& options) {
  study.reduce(outcomes, folder, watch_of(options, "summary"));
  if (!study.manifest) return;
  write_manifest(study, outcomes, folder);
  write_items(folder, results_key(study, outcomes), list.size(), [&](std::size_t i) {
    const Outcome& outcome = outcomes.at(list[i].id);
    return DoneItem{list[i].id, outcome.key, outcome.json()};
  });
}

// Removes items that are none of these: an earlier run of another study or shard may have left them.
void keep_items(const fs::path& output, const Outcomes& outcomes) {
  std::vector<fs::path> others;
  if (!fs::exists(output / kItemsFolder)) return;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(output / kItemsFolder))
    if (entry.path().filename() == kItemFile) {
      const fs::path folder = entry.path().parent_path();
      if (!outcomes.contains(folder.lexically_relative(output / kItemsFolder).generic_string()))
        others.push_back(folder);
    }
  for (const fs::path& folder : others) fs::remove_all(folder);
}

void write_record(const Study& study, const fs::path& folder, Json times, const RunningTime& start) {
  if (study.hashes) study.hashes->save(folder);
  if (study.times) times.update(study.times());
  write_run_record(folder, times, start.seconds(), tbb::this_task_arena::max_concurrency());
}

}  // namespace

std::string key_of(const Json& settings) {
  return hash_of_text(json_text(Json{{"build", build_id()}, {"settings", settings}}, -1));
}

Json Outcome::json() const {
  if (gathered) return *gathered;
  std::optional<StoredItem> stored = stored_item(folder);
  if (!stored) throw InputError(folder.string(), "was removed while it was read");
  return std::move(stored->outcome);
}

std::string Outcome::place() const {
  return gathered ? (folder / "items.json").string() : (folder / kItemFile).string() + " outcome";
}

Json manifest_of(const Json& resolved, const Json& more) {
  Json manifest{{"study", resolved}, {"study_sha256", hash_of_text(resolved.dump())}};
  manifest.update(more);
  return manifest;
}

Json manifest_of_generated(const Json& resolved) {
  return manifest_of(resolved, {{"simulated", true}, {"inputs", Json::array()}});
}

ItemTally run_study(const Study& study, const fs::path& output, const StudyOptions& options) {
  const bool asked = std::ranges::find(options.reuse, output) != options.reuse.end();
  if (asked && options.shard.whole() && !study.key && holds_results(output, key_of(study.work))) {
    ItemTally tally;
    for (const Item& item : study.items) tally.reused.push_back(item.id);
    tally.unchanged = true;
    return tally;
  }
  const ResultsFolder results(output, !options.fresh);
  const fs::path& folder = results.partial();
  ItemTally tally;
  on_threads(options.threads, [&](int) {
    const RunningTime start;
    Run run(study, folder, options);
    run.compute();
    tally = run.tally();
    if (study.write_beside) study.write_beside(folder);
    if (study.time && options.shard.number == 1) study.time(folder, watch_of(options, "timing"));
    Json times = run.times();
    times.update(
        Json{{"computed", tally.computed}, {"continued", tally.continued}, {"reused", tally.reused}});
    if (options.shard.whole()) {
      write_results(study, run.list(), run.outcomes(), folder, options);
      run.check_earlier();
      if (!study.manifest) return;
    } else {
      run.check_earlier();
      keep_items(folder, run.outcomes());
      write_part(folder,
                 {study.kind, build_id(), options.shard.number, options.shard.of, study.work, run.list()});
    }
    write_record(study, folder, std::move(times), start);
  });
  results.put_in_place(!options.shard.whole());
  return tally;
}

void merge_parts(const Study& study, std::span<const FoundPart> parts, const fs::path& output,
                 const StudyOptions& options) {
  const ResultsFolder results(output);
  const fs::path& folder = results.partial();
  WatchedFiles lists;
  for (const FoundPart& part : parts) lists.add(part.folder / "part.json");
  on_threads(options.threads, [&](int) {
    const RunningTime start;
    const Outcomes outcomes = outcomes_of(parts);
    for (const fs::directory_entry& entry : fs::directory_iterator(parts.front().folder)) {
      const std::string name = entry.path().filename().string();
      if (name != kItemsFolder && name != "part.json" && name != "run.json" && name != "hashes.json")
        fs::copy(entry.path(), folder / name);
    }
    if (study.hashes)
      for (const FoundPart& part : parts) study.hashes->load(part.folder);
    write_results(study, parts.front().part.items, outcomes, folder, options);
    if (study.manifest) write_record(study, folder, {{"parts", parts.size()}}, start);
  });
  lists.check();
  results.put_in_place();
}

}  // namespace trilat
