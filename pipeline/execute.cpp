// SPDX-License-Identifier: MIT
#include "pipeline/execute.h"

#include <algorithm>
#include <chrono>

#include "datasets/results/declared_parameters.h"
#include "datasets/results/replay.h"
#include "pipeline/manifest.h"
#include "pipeline/plan.h"
#include "pipeline/results_folder.h"
#include "pipeline/rig_gdop.h"
#include "pipeline/runner.h"
#include "pipeline/summarise.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

ResultsSummary execute_into(const StudySpec& study, const Campaign& campaign,
                            const std::filesystem::path& folder, const ExecuteOptions& options, int threads) {
  const Clock::time_point start = Clock::now();
  const Plan plan = make_plan(study, campaign);
  SamplesFile samples = SamplesFile::create(folder / "samples.h5", samples_header(plan));
  constexpr double kRunShare = 0.8;  // of the whole; the rest is the summary
  const auto from = [&](double before, double share) -> std::function<void(double)> {
    if (!options.progress) return {};
    return [&options, before, share](double done) { options.progress(before + share * done); };
  };
  RunOutcome outcome =
      run_plan(plan, samples,
               {options.cross_check, options.stop_requested, from(0.0, kRunShare), options.memory_bytes});
  const Clock::time_point summary_start = Clock::now();
  const ResultsSummary summary =
      summarise(plan, outcome, samples, std::min(kDistancesInMemoryBytes, options.memory_bytes / 2),
                from(kRunShare, 1.0 - kRunShare));
  outcome.times.summarise_s = seconds_since(summary_start);
  samples.finish();
  write_manifest(folder, plan, options.stop_requested);
  write_summary(folder, summary);
  write_tracking_summary(folder, outcome.tracking);
  if (const auto map = rig_gdop(plan)) write_gdop_map(folder, *map);
  if (!outcome.replays.empty()) write_replay(folder, outcome.replays);
  if (const auto parameters = read_declared_parameters(campaign.folder); !parameters.empty())
    write_declared_parameters(folder, parameters);
  write_run_record(folder, outcome.times, seconds_since(start), threads);
  return summary;
}

}  // namespace

ResultsSummary execute_study(const StudySpec& study, const Campaign& campaign,
                             const std::filesystem::path& output, const ExecuteOptions& options) {
  const ResultsFolder folder(output);
  ResultsSummary summary;
  on_threads(options.threads, [&](int threads) {
    summary = execute_into(study, campaign, folder.partial(), options, threads);
  });
  folder.put_in_place();
  return summary;
}

}  // namespace trilat
