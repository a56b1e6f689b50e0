// SPDX-License-Identifier: MIT
#include "pipeline/execute.h"

#include <algorithm>
#include <numeric>

#include "datasets/results/declared_parameters.h"
#include "pipeline/assemble.h"
#include "pipeline/manifest.h"
#include "pipeline/parallel.h"
#include "pipeline/plan.h"
#include "pipeline/results_folder.h"
#include "pipeline/rig_gdop.h"
#include "pipeline/runner.h"
#include "pipeline/take_folder.h"
#include "pipeline/take_key.h"
#include "pipeline/watch.h"

namespace trilat {
namespace {

constexpr double kRunShare = 0.8;  // of the progress; the rest is the summary

// Whether `output` holds what this run would give, to the byte.
bool is_done_already(const StudySpec& study, const Campaign& campaign, const std::filesystem::path& output,
                     const ExecuteOptions& options, HashCache& hashes) {
  if (std::find(options.reuse.begin(), options.reuse.end(), output) == options.reuse.end()) return false;
  const std::string known = read_items_key(output);
  // a journal is there when it could not be removed at the end: then all is put in place again
  if (known.empty() || std::filesystem::exists(output / ItemJournal::kFile)) return false;
  for (const char* file : {"samples.h5", "replay.h5", "manifest.json", "summary.json", "tracking.json",
                           "gdop_map.json", "run.json"})
    if (!std::filesystem::exists(output / file)) return false;
  const Campaign takes = takes_of(study, campaign);
  RunIdentity run{study,
                  options.cross_check,
                  takes.name,
                  takes.simulated,
                  read_declared_parameters(takes.folder),
                  takes.takes,
                  {}};
  if (!run.parameters.empty() && !std::filesystem::exists(output / "simulator.json")) return false;
  run.inputs.resize(run.takes.size());
  parallel_for_index(run.takes.size(), 1, [&](std::size_t t) {
    if (!options.stop_requested || !options.stop_requested())
      run.inputs[t] = inputs_of(run.takes[t], hashes, options.stop_requested);
  });
  return key_of_run(run) == known;
}

void run_into(const StudySpec& study, const Campaign& campaign, const ResultsFolder& folder,
              const ExecuteOptions& options, HashCache& hashes, int threads, StudyRun& run) {
  const RunningTime start;
  std::vector<WatchedFiles> inputs;
  for (const Take& take : takes_of(study, campaign).takes) inputs.push_back(watched_files(take));
  const Plan plan = make_plan(study, campaign);
  ItemStore items(folder.partial(), options.reuse);
  std::vector<std::size_t> all(plan.takes.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  TakesRun takes = run_takes(plan, all, {folder.partial(), items, hashes, std::move(inputs)},
                             {options.cross_check, options.stop_requested,
                              share_of(options.progress, 0.0, kRunShare), options.memory_bytes});
  run.takes = items.tally();
  const RunParts parts{plan, std::move(takes.takes), options.cross_check,
                       read_declared_parameters(campaign.folder), rig_gdop(plan)};
  run.summary = assemble(
      parts, folder.partial(), takes.times,
      {options.stop_requested, share_of(options.progress, kRunShare, 1.0 - kRunShare), options.memory_bytes});
  hashes.save(folder.partial());
  write_run_record(folder.partial(), takes.times, start.seconds(), threads, &run.takes);
  items.check_earlier();
  folder.put_in_place({kTakesFolder, ItemJournal::kFile});
}

}  // namespace

StudyRun run_study(const StudySpec& study, const Campaign& campaign, const std::filesystem::path& output,
                   const ExecuteOptions& options) {
  StudyRun run;
  HashCache hashes;
  for (const std::filesystem::path& earlier : options.reuse) hashes.load(earlier);
  on_threads(options.threads, [&](int threads) {
    run.unchanged = is_done_already(study, campaign, output, options, hashes);
    if (run.unchanged) {
      run.summary = read_summary(output);
      for (const Take& take : takes_of(study, campaign).takes) run.takes.reused.push_back(take.id);
      return;
    }
    const ResultsFolder folder(output, options.fresh ? Kept{} : Kept{ItemJournal::kFile, kTakesFolder});
    run_into(study, campaign, folder, options, hashes, threads, run);
  });
  return run;
}

ResultsSummary execute_study(const StudySpec& study, const Campaign& campaign,
                             const std::filesystem::path& output, const ExecuteOptions& options) {
  return run_study(study, campaign, output, options).summary;
}

}  // namespace trilat
