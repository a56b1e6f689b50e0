// SPDX-License-Identifier: MIT
#include "pipeline/study/results_run.h"

#include <algorithm>
#include <atomic>
#include <numeric>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSummary = "summary.json";

std::string stage_of(const std::string& id) { return id.substr(0, id.find('/')); }

// How far items are that are computed beside each other.
class StageProgress {
 public:
  StageProgress(std::vector<double> costs, RunControl control)
      : control_(std::move(control)),
        costs_(std::move(costs)),
        done_(costs_.size()),
        all_(std::accumulate(costs_.begin(), costs_.end(), 0.0)) {}
  // Control of the item of that index.
  RunControl item(std::size_t index) {
    return {control_.stop_requested, [this, index](double share) { report(index, share); }};
  }

 private:
  void report(std::size_t index, double share) {
    const std::lock_guard lock(mutex_);
    sum_ += costs_[index] * (share - done_[index]);
    done_[index] = share;
    control_.report(sum_ / all_);
  }

  RunControl control_;
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

// Several shards may begin at once, so it is written aside under a name of this process.
void put_manifest(const ItemStore& store, const fs::path& results, const Json& manifest) {
  const ItemStore::StagingFolder aside(store);
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

}  // namespace

ResultsRun::ResultsRun(fs::path results, std::vector<Item> items, const StudyOptions& options)
    : results_(std::move(results)),
      items_(std::move(items)),
      options_(options),
      store_(results_),
      keys_(items_.size()) {
  if (options.mark) options.mark();
  make_folder(results_);
  if (is_whole()) lock_.emplace(fs::canonical(results_));
  std::vector<double> costs;
  for (const Item& item : items_) costs.push_back(item.cost);
  const std::vector<std::uint64_t> owner = shards_of(costs, options.shard.of);
  for (std::size_t i = 0; i < owner.size(); ++i)
    if (owner[i] == options.shard.number) mine_.push_back(i);
}

RunControl ResultsRun::control(const std::string& stage) const { return control_of(options_, stage); }

void ResultsRun::find_keys(const std::function<std::string(std::size_t, const RunControl&)>& key_of) {
  const RunControl inputs = control("inputs");
  std::atomic<std::size_t> done{0};
  parallel_for_index(mine_.size(), 1, [&](std::size_t k) {
    inputs.check();
    keys_[mine_[k]] = key_of(mine_[k], inputs);
    inputs.report(static_cast<double>(++done) / static_cast<double>(mine_.size()));
  });
}

bool ResultsRun::is_finished(const Json& manifest) {
  if (!is_whole() || options_.fresh || !fs::exists(results_ / kSummary)) return false;
  const bool has_all = std::ranges::all_of(mine_, [&](std::size_t i) {
    try {
      return !keys_[i].empty() && store_.find(keys_[i]);
    } catch (const InputError&) {
      return false;
    }
  });
  if (!has_all || manifest_in(results_) != with_items(manifest)) return false;
  for (const std::size_t i : mine_) tally_.found.push_back(items_[i].id);
  tally_.unchanged = true;
  return true;
}

void ResultsRun::begin(const Json& manifest) {
  const Json whole = with_items(manifest);
  if (!is_whole() && manifest_in(results_) == whole) return;
  fs::remove(results_ / kSummary);  // a summary of other inputs is none of these
  put_manifest(store_, results_, whole);
}

void ResultsRun::compute(
    const std::function<ComputedItem(std::size_t, const fs::path&, const RunControl&)>& compute_item) {
  const ItemStore::StagingFolder aside(store_);
  std::span<const std::size_t> left = mine_;
  while (!left.empty()) {
    const std::string stage = stage_of(items_[left[0]].id);
    std::size_t count = 1;
    while (count < left.size() && stage_of(items_[left[count]].id) == stage) ++count;
    const RunningTime time;
    compute_stage(left.first(count), aside.path(), control(stage), compute_item);
    times_[stage + "_s"] = time.seconds();
    left = left.subspan(count);
  }
}

void ResultsRun::compute_stage(std::span<const std::size_t> items, const fs::path& aside,
                               const RunControl& control, const auto& compute_item) {
  std::vector<double> costs;
  for (const std::size_t i : items) costs.push_back(items_[i].cost);
  StageProgress progress(std::move(costs), control);
  std::atomic<std::size_t> next{0};
  const std::size_t step = step_through(items.size());
  parallel_for_index(items.size(), 1, [&](std::size_t) {
    try {
      for (std::size_t n; (n = next++) < items.size();) {
        const std::size_t k = n * step % items.size();
        const RunControl of_item = progress.item(k);
        of_item.check();
        take(items[k], aside / std::to_string(items[k]), of_item, compute_item);
        of_item.report(1.0);
      }
    } catch (...) {
      next = items.size();  // no thread begins another
      throw;
    }
  });
}

void ResultsRun::take(std::size_t i, const fs::path& aside, const RunControl& control,
                      const auto& compute_item) {
  const Item& item = items_[i];
  ItemResult outcome{keys_[i], store_.folder(keys_[i]), {}, false};
  const bool found = find(item, outcome);
  if (!found) {
    make_folder(aside);
    ComputedItem computed = compute_item(i, aside, control);
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

bool ResultsRun::find(const Item& item, ItemResult& outcome) {
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

// With the keys that are known; of a failed item none.
Json ResultsRun::with_items(Json manifest) const {
  Json items = Json::object();
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const auto outcome = outcomes_.find(items_[i].id);
    const bool failed = outcome != outcomes_.end() && outcome->second.failed;
    items[items_[i].id] = keys_[i].empty() || failed ? Json() : Json(keys_[i]);
  }
  Json whole{{"format", "trilat.manifest"}, {"version", 2}, {"program", kProgramVersion}};
  whole.update(manifest);
  whole["items"] = items;
  return whole;
}

void ResultsRun::publish(const std::string& mark, const std::function<bool(const fs::path&)>& is_earlier,
                         const std::function<void(const fs::path&)>& write) {
  {
    const ItemStore::StagingFolder aside(store_);
    write(aside.path());
    trilat::publish(aside.path(), results_, mark, is_earlier);
  }
  store_.remove_all_but({keys_.begin(), keys_.end()});
}

void ResultsRun::publish_results(const Json& manifest, const std::function<void(const fs::path&)>& write) {
  if (!tally_.failed.empty()) put_manifest(store_, results_, with_items(manifest));
  publish(kSummary, is_of_summary, [&](const fs::path& into) {
    write(into);
    Json times = times_;
    times.update(Json{{"computed", tally_.computed}, {"found", tally_.found}});
    write_run_record(into, results_, times, start_.seconds(), tbb::this_task_arena::max_concurrency());
  });
}

}  // namespace trilat
