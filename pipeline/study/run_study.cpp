// SPDX-License-Identifier: MIT
#include "datasets/base/content_hash.h"
#include "datasets/base/version.h"
#include "pipeline/study/parallel.h"
#include "pipeline/study/results_run.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

std::vector<ResultsRun::Item> items_of(const Study& study) {
  std::vector<ResultsRun::Item> items;
  for (const Item& item : study.items) items.push_back({item.id, item.cost});
  return items;
}

void find_keys(const Study& study, ResultsRun& run) {
  run.find_keys([&](std::size_t i, const Watch& watch) {
    const Item& item = study.items[i];
    return item.key ? item.key(watch) : key_of({{"study", study.settings}, {"item", item.id}});
  });
}

void compute(const Study& study, ResultsRun& run) {
  run.compute([&](std::size_t i, const fs::path& into, const Watch& watch) {
    return study.items[i].compute(into, watch);
  });
}

ItemTally run_items(const Study& study, const fs::path& results, const StudyOptions& options) {
  ResultsRun run(results, items_of(study), options);
  find_keys(study, run);
  const Json manifest = study.manifest();
  if (run.is_finished(manifest)) return run.tally();
  run.begin(manifest);
  if (study.hashes && run.is_whole()) study.hashes->save(results);
  compute(study, run);
  if (run.is_whole())
    run.publish_results(manifest, [&](const fs::path& into) {
      if (study.write_beside) study.write_beside(into);
      if (study.time) study.time(into, run.watch("timing"));
      study.reduce(run.outcomes(), into, run.watch("summary"));
    });
  return run.tally();
}

}  // namespace

Watch watch_of(const StudyOptions& options, const std::string& stage) {
  Watch watch{options.stop_requested, {}};
  if (options.progress) watch.progress = [&options, stage](double share) { options.progress(stage, share); };
  return watch;
}

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
  ItemTally tally;
  on_threads(options.threads, [&](int) { tally = run_items(study, results, options); });
  return tally;
}

ItemTally run_to_files(const Study& study, const fs::path& output, const StudyOptions& options,
                       const std::string& mark, const std::function<bool(const fs::path&)>& is_earlier) {
  ItemTally tally;
  on_threads(options.threads, [&](int) {
    ResultsRun run(output, items_of(study), options);
    find_keys(study, run);
    compute(study, run);
    run.publish(mark, is_earlier, [&](const fs::path& into) {
      if (study.write_beside) study.write_beside(into);
      study.reduce(run.outcomes(), into, run.watch("summary"));
    });
    tally = run.tally();
  });
  const ItemStore store(output);
  store.remove_all_but({});
  store.remove_if_empty();
  return tally;
}

}  // namespace trilat
