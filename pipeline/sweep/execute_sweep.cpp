// SPDX-License-Identifier: MIT
#include "pipeline/sweep/execute_sweep.h"

#include <chrono>

#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "pipeline/manifest.h"
#include "pipeline/results_folder.h"
#include "pipeline/sweep/interpretation_search.h"
#include "pipeline/sweep/sweep_runner.h"
#include "pipeline/sweep/sweep_timing.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

SweepSummary summary_of(const SweepPlan& plan, SweepRun run) {
  SweepSummary s;
  s.study = plan.spec.name;
  s.seed = plan.spec.seed;
  s.trials = plan.spec.trials;
  s.max_iterations = plan.spec.max_iterations;
  s.interrupted = run.interrupted;
  s.skipped = plan.skipped;
  s.thresholds = plan.spec.thresholds;
  s.ranges = plan.spec.ranges;
  for (const SweepReading& reading : plan.readings) s.interpretations.push_back(reading.text);
  s.cells = std::move(run.cells);
  if (plan.spec.search && !s.interrupted) s.search = search_interpretations(s, printed_table1());
  return s;
}

void write_sweep_manifest(const std::filesystem::path& folder, const SweepPlan& plan) {
  const Json study = resolved_json(plan.spec);
  const Json json{{"format", "trilat.manifest"},
                  {"version", 1},
                  {"program", kProgramVersion},
                  {"study", study},
                  {"study_sha256", hash_of_text(study.dump())},
                  {"simulated", true},
                  {"interpretations", plan.readings.size()},
                  {"skipped", plan.skipped},
                  {"cells", plan.cells()},
                  {"trials", plan.cells() * plan.spec.trials},
                  {"inputs", Json::array()}};
  write_file(folder / "manifest.json", json_text(json, 1) + "\n");
}

SweepOutcome execute_into(const SweepPlan& plan, const std::filesystem::path& folder,
                          const ExecuteSweepOptions& options, int threads) {
  const Clock::time_point start = Clock::now();
  SweepOutcome outcome;
  write_sweep_manifest(folder, plan);
  outcome.summary = summary_of(plan, run_sweep(plan, {options.stop_requested, options.progress}));
  const double trials_s = seconds_since(start);
  if (plan.spec.time_problems > 0 && !outcome.summary.interrupted) {
    outcome.timings = time_sweep(plan, options.stop_requested, options.timing_progress);
    outcome.summary.interrupted = !outcome.timings;
  }
  write_sweep_summary(folder, outcome.summary);
  if (outcome.timings) write_sweep_timings(folder, *outcome.timings);
  const double wall_s = seconds_since(start);
  write_run_record(folder, {{"trials_s", trials_s}, {"timing_s", wall_s - trials_s}}, wall_s, threads);
  return outcome;
}

}  // namespace

SweepOutcome execute_sweep(const SweepPlan& plan, const std::filesystem::path& output,
                           const ExecuteSweepOptions& options) {
  const ResultsFolder folder(output);
  SweepOutcome outcome;
  on_threads(options.threads,
             [&](int threads) { outcome = execute_into(plan, folder.partial(), options, threads); });
  outcome.folder = outcome.summary.interrupted ? folder.partial() : output;
  if (!outcome.summary.interrupted) folder.put_in_place();
  return outcome;
}

}  // namespace trilat
