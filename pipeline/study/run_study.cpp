// SPDX-License-Identifier: MIT
#include <algorithm>
#include <atomic>
#include <mutex>
#include <numeric>
#include <set>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "pipeline/study/machine.h"
#include "pipeline/study/parallel.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSummary = "summary.json";

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
  Run(const Study& study, const fs::path& results, const StudyOptions& options)
      : study_(study), options_(options), store_(results), keys_(study.items.size()) {
    std::vector<double> costs;
    for (const Item& item : study.items) costs.push_back(item.cost);
    const std::vector<std::uint64_t> owner = shards_of(costs, options.shard.of);
    for (std::size_t i = 0; i < owner.size(); ++i)
      if (owner[i] == options.shard.number) mine_.push_back(i);
  }

  void find_keys() {
    const Watch watch = watch_of(options_, "inputs");
    std::atomic<std::size_t> done{0};
    parallel_for_index(mine_.size(), 1, [&](std::size_t k) {
      watch.check();
      const Item& item = study_.items[mine_[k]];
      keys_[mine_[k]] =
          item.key ? item.key(watch) : trilat::key_of({{"study", study_.settings}, {"item", item.id}});
      watch.tell(static_cast<double>(++done) / static_cast<double>(mine_.size()));
    });
  }
  bool has_all() const {
    return std::ranges::all_of(mine_, [&](std::size_t i) {
      try {
        return !keys_[i].empty() && store_.find(keys_[i]);
      } catch (const InputError&) {
        return false;
      }
    });
  }

  void compute() {
    const ItemStore::Aside aside(store_);
    std::span<const std::size_t> left = mine_;
    while (!left.empty()) {
      const std::string stage = stage_of(study_.items[left[0]].id);
      std::size_t count = 1;
      while (count < left.size() && stage_of(study_.items[left[count]].id) == stage) ++count;
      const RunningTime time;
      compute_stage(left.first(count), aside.path(), watch_of(options_, stage));
      times_[stage + "_s"] = time.seconds();
      left = left.subspan(count);
    }
  }

  const ItemStore& store() const { return store_; }
  const Outcomes& outcomes() const { return outcomes_; }
  ItemTally& tally() { return tally_; }
  const Json& times() const { return times_; }
  std::vector<std::string> ids() const {
    std::vector<std::string> ids;
    for (const std::size_t i : mine_) ids.push_back(study_.items[i].id);
    return ids;
  }
  std::set<std::string> keys() const { return {keys_.begin(), keys_.end()}; }

  // With the keys that are known; of a failed item none.
  Json manifest() const {
    Json items = Json::object();
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      const auto outcome = outcomes_.find(study_.items[i].id);
      const bool failed = outcome != outcomes_.end() && outcome->second.failed;
      items[study_.items[i].id] = keys_[i].empty() || failed ? Json() : Json(keys_[i]);
    }
    Json manifest{{"format", "trilat.manifest"}, {"version", 2}, {"program", kProgramVersion}};
    manifest.update(study_.manifest());
    manifest["items"] = items;
    return manifest;
  }

 private:
  void compute_stage(std::span<const std::size_t> items, const fs::path& aside, const Watch& watch) {
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
          take(items[k], aside / std::to_string(items[k]), of_item);
          of_item.tell(1.0);
        }
      } catch (...) {
        next = items.size();  // no thread begins another
        throw;
      }
    });
  }

  void take(std::size_t i, const fs::path& aside, const Watch& watch) {
    const Item& item = study_.items[i];
    Outcome outcome{keys_[i], store_.folder(keys_[i]), {}, false};
    const bool found = find(item, outcome);
    if (!found) {
      make_folder(aside);
      Computed computed = item.compute(aside, watch);
      outcome.json = std::move(computed.outcome);
      outcome.failed = computed.failed;
      if (outcome.key.empty() && !outcome.failed)
        throw InputError(item.id, "was evaluated, although its files could not be read before; run again");
      if (outcome.failed)
        fs::remove_all(aside);
      else
        store_.put(aside, {item.id, outcome.key, outcome.json, {}});
    }
    const std::lock_guard lock(mutex_);
    if (outcome.failed)
      tally_.failed[item.id] = outcome.json;
    else
      (found ? tally_.found : tally_.computed).push_back(item.id);
    outcomes_[item.id] = std::move(outcome);
  }

  bool find(const Item& item, Outcome& outcome) {
    if (outcome.key.empty() || options_.fresh) return false;
    try {
      std::optional<StoredItem> stored = store_.find(outcome.key);
      if (!stored) return false;
      outcome.json = std::move(stored->outcome);
      return true;
    } catch (const InputError& error) {
      const std::lock_guard lock(mutex_);
      tally_.damaged.push_back(fmt::format("{}: {}", item.id, error.what()));
      return false;
    }
  }

  const Study& study_;
  const StudyOptions& options_;
  const ItemStore store_;
  std::vector<std::string> keys_;  // by item of the study; of other shards' none
  std::vector<std::size_t> mine_;
  std::mutex mutex_;
  Outcomes outcomes_;
  ItemTally tally_;
  Json times_ = Json::object();
};

// Several shards may begin at once, so it is written aside under a name of this process.
void put_manifest(const ItemStore& store, const fs::path& results, const Json& manifest) {
  const ItemStore::Aside aside(store);
  write_file(aside.path() / "manifest.json", json_text(manifest, 1) + "\n");
  fs::rename(aside.path() / "manifest.json", results / "manifest.json");
}

Json manifest_in(const fs::path& results) {
  try {
    return fs::exists(results / "manifest.json") ? read_json(results / "manifest.json") : Json();
  } catch (const InputError&) {
    return {};  // damaged: it is written again
  }
}

// The results are no longer those of another study or of other settings.
void begin(const Run& run, const fs::path& results, const Json& manifest) {
  fs::remove(results / kSummary);
  put_manifest(run.store(), results, manifest);
}

// Moves what is in `made` into the output, the mark last; what an earlier run left there is replaced.
void publish(const fs::path& made, const fs::path& output, const std::string& mark,
             const std::function<bool(const fs::path&)>& is_earlier) {
  fs::remove(output / mark);
  std::vector<fs::path> earlier, fresh;
  for (const fs::directory_entry& entry : fs::directory_iterator(output))
    if (is_earlier(entry.path())) earlier.push_back(entry.path());
  for (const fs::path& path : earlier) fs::remove_all(path);
  for (const fs::directory_entry& entry : fs::directory_iterator(made))
    if (entry.path().filename() != mark) fresh.push_back(entry.path());
  fresh.push_back(made / mark);
  for (const fs::path& path : fresh) {
    std::error_code error;
    fs::rename(path, output / path.filename(), error);
    if (error)
      throw OutputError((output / path.filename()).string(), "cannot be put in place: " + error.message());
  }
}

// The files that studies write beside their summary and that this one may lack; whatever else lies in the
// folder stays.
bool is_of_summary(const fs::path& path) {
  const std::string name = path.filename().string();
  return name == "simulator.json" || name == "timings.json" || name == "tracking.json" ||
         name == "points.csv" || name == "sweep.csv" || name == "by-take-and-joint.csv" ||
         name == "tables.json" || name == "figures.json" || name == "numbers.csv" ||
         (name.starts_with("agreement-") && name.ends_with(".csv"));
}

void write_summary(const Study& study, Run& run, const fs::path& results, const StudyOptions& options,
                   const RunningTime& start) {
  const ItemStore::Aside aside(run.store());
  const fs::path& folder = aside.path();
  if (study.write_beside) study.write_beside(folder);
  if (study.time) study.time(folder, watch_of(options, "timing"));
  study.reduce(run.outcomes(), folder, watch_of(options, "summary"));
  Json times = run.times();
  times.update(Json{{"computed", run.tally().computed}, {"found", run.tally().found}});
  write_run_record(folder, results, times, start.seconds(), tbb::this_task_arena::max_concurrency());
  publish(folder, results, kSummary, is_of_summary);
}

void run_shard(Run& run, const fs::path& results) {
  run.find_keys();
  // A summary of other inputs is none of these.
  if (const Json manifest = run.manifest(); manifest_in(results) != manifest) begin(run, results, manifest);
  run.compute();
}

void run_whole(const Study& study, Run& run, const fs::path& results, const StudyOptions& options) {
  const RunningTime start;
  run.find_keys();
  const Json manifest = run.manifest();
  if (!options.fresh && fs::exists(results / kSummary) && run.has_all() && manifest_in(results) == manifest) {
    run.tally().found = run.ids();
    run.tally().unchanged = true;
    return;
  }
  begin(run, results, manifest);
  if (study.hashes) study.hashes->save(results);
  run.compute();
  if (!run.tally().failed.empty()) put_manifest(run.store(), results, run.manifest());
  write_summary(study, run, results, options, start);
  run.store().remove_all_but(run.keys());
}

}  // namespace

std::string key_of(const Json& settings) {
  return hash_of_text(json_text(Json{{"build", build_id()}, {"settings", settings}}, -1));
}

Json manifest_of(const Json& resolved, const Json& more) {
  Json manifest{{"study", resolved}, {"study_sha256", hash_of_text(resolved.dump())}};
  manifest.update(more);
  return manifest;
}

Json manifest_of_generated(const Json& resolved) {
  return manifest_of(resolved, {{"simulated", true}, {"inputs", Json::array()}});
}

ItemTally run_study(const Study& study, const fs::path& results, const StudyOptions& options) {
  make_folder(results);
  std::optional<FolderLock> lock;
  if (options.shard.whole()) lock.emplace(fs::canonical(results));
  Run run(study, results, options);
  on_threads(options.threads, [&](int) {
    if (options.shard.whole())
      run_whole(study, run, results, options);
    else
      run_shard(run, results);
  });
  return std::move(run.tally());
}

ItemTally run_to_files(const Study& study, const fs::path& output, const StudyOptions& options,
                       const std::string& mark, const std::function<bool(const fs::path&)>& is_earlier) {
  make_folder(output);
  const FolderLock lock(fs::canonical(output));
  Run run(study, output, options);
  on_threads(options.threads, [&](int) {
    run.find_keys();
    run.compute();
    const ItemStore::Aside aside(run.store());
    if (study.write_beside) study.write_beside(aside.path());
    study.reduce(run.outcomes(), aside.path(), watch_of(options, "summary"));
    publish(aside.path(), output, mark, is_earlier);
  });
  run.store().remove_all_but({});
  run.store().remove_if_empty();
  return std::move(run.tally());
}

}  // namespace trilat
