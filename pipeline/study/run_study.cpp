// SPDX-License-Identifier: MIT
#include <algorithm>
#include <mutex>

#include "datasets/base/content_hash.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "pipeline/manifest.h"
#include "pipeline/parallel.h"
#include "pipeline/results_folder.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

std::string stage_of(const std::string& id) { return id.substr(0, id.find('/')); }

Watch watch_of(const StudyOptions& options, const std::string& stage) {
  Watch watch{options.stop_requested, {}};
  if (options.progress) watch.progress = [&options, stage](double share) { options.progress(stage, share); };
  return watch;
}

// Items of one stage, of which several are computed at a time.
class Stage {
 public:
  Stage(std::span<const Item> items, const StudyItems& known, Watch watch) : watch_(std::move(watch)) {
    for (const Item& item : items) costs_.push_back(known.has(item.id) ? item.cost : 0.0);
    done_.resize(items.size());
  }
  // The watch of the item of that index.
  Watch item(std::size_t index) {
    return {watch_.stop_requested, [this, index](double share) { tell(index, share); }};
  }

 private:
  void tell(std::size_t index, double share) {
    const std::lock_guard lock(mutex_);
    done_[index] = share;
    double done = 0.0, all = 0.0;
    for (std::size_t i = 0; i < costs_.size(); ++i) {
      done += costs_[i] * done_[i];
      all += costs_[i];
    }
    watch_.tell(done / all);
  }

  Watch watch_;
  std::mutex mutex_;
  std::vector<double> costs_, done_;  // by item; another shard's costs nothing
};

// Those of another shard are left out. When merging, nothing is left out and nothing computed.
Outcomes outcomes_of(const Study& study, StudyItems& items, const std::filesystem::path& scratch,
                     const StudyOptions& options, Json& times) {
  std::vector<std::optional<Json>> found(study.items.size());
  for (auto first = study.items.begin(); first != study.items.end();) {
    const RunningTime time;
    const std::string name = stage_of(first->id);
    const auto end =
        std::find_if(first, study.items.end(), [&](const Item& item) { return stage_of(item.id) != name; });
    Stage stage({first, end}, items, watch_of(options, name));
    const auto before = static_cast<std::size_t>(first - study.items.begin());
    parallel_for_index(static_cast<std::size_t>(end - first), 1, [&](std::size_t i) {
      const Item& item = study.items[before + i];
      const Watch watch = stage.item(i);
      found[before + i] = items.outcome(item.id, [&] {
        watch.check();
        return item.compute(scratch, watch);
      });
      if (found[before + i]) watch.tell(1.0);
    });
    times[name + "_s"] = time.seconds();
    first = end;
  }
  Outcomes outcomes;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (const std::string& id = study.items[i].id; found[i])
      outcomes[id] = {std::move(*found[i]), items.place_of(id)};
  return outcomes;
}

void write_results(const Study& study, const Outcomes& outcomes, const std::filesystem::path& folder,
                   const StudyOptions& options) {
  Json manifest{{"format", "trilat.manifest"}, {"version", 1}, {"program", kProgramVersion}};
  manifest.update(study.manifest);
  write_file(folder / "manifest.json", json_text(manifest, 1) + "\n");
  study.reduce(outcomes, folder, watch_of(options, "summary"));
}

std::vector<PartItem> list_of(const Study& study) {
  std::vector<PartItem> list;
  for (const Item& item : study.items) list.push_back({item.id, item.cost});
  return list;
}

std::string key_of(const Study& study) { return key_of_item(study.work); }

bool is_known(const Study& study, const std::filesystem::path& output, const StudyOptions& options,
              ItemTally& tally) {
  std::vector<const char*> files;
  if (!study.parameters.empty()) files.push_back("simulator.json");
  if (study.time) files.push_back("timings.json");
  return is_done_already(output, options.work, key_of(study), list_of(study), files, &tally);
}

}  // namespace

Json manifest_of(const Json& resolved, const Json& more) {
  Json manifest{{"study", resolved}, {"study_sha256", hash_of_text(resolved.dump())}};
  manifest.update(more);
  return manifest;
}

ItemTally run_study(const Study& study, const std::filesystem::path& output, const StudyOptions& options) {
  ItemTally tally;
  if (is_known(study, output, options, tally)) return tally;
  const ResultsFolder results(output, options.fresh ? Kept{} : Kept{ItemJournal::kFile});
  const std::filesystem::path& folder = results.partial();
  on_threads(options.threads, [&](int threads) {
    const RunningTime start;
    Json times = Json::object();
    StudyItems items(name_of(study.kind), study.work, list_of(study), folder, options.work);
    const Outcomes outcomes = outcomes_of(study, items, folder, options, times);
    if (items.whole()) write_results(study, outcomes, folder, options);
    if (!study.parameters.empty()) write_declared_parameters(folder, study.parameters);
    if (study.time && items.first())
      write_stage_timings(folder, study.time(folder, watch_of(options, "timing")));
    items.finish(folder, key_of(study));
    tally = items.tally();
    times.update(json_of(tally));
    write_run_record(folder, times, start.seconds(), threads);
  });
  results.put_in_place();
  return tally;
}

void merge_parts(const Study& study, std::span<const FoundPart> parts, const std::filesystem::path& output,
                 const StudyOptions& options) {
  const ResultsFolder results(output);
  const std::filesystem::path &folder = results.partial(), &first = parts.front().folder;
  on_threads(options.threads, [&](int threads) {
    const RunningTime start;
    Json times = Json::object();
    StudyItems items(std::vector<FoundPart>(parts.begin(), parts.end()));
    write_results(study, outcomes_of(study, items, folder, options, times), folder, options);
    if (const auto parameters = read_declared_parameters(first); !parameters.empty())
      write_declared_parameters(folder, parameters);
    if (const auto timings = read_stage_timings(first)) write_stage_timings(folder, *timings);
    items.finish(folder, key_of(study));
    write_run_record(folder, times, start.seconds(), threads);
  });
  results.put_in_place();
}

}  // namespace trilat
