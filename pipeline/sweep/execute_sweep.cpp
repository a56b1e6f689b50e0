// SPDX-License-Identifier: MIT
#include "pipeline/sweep/execute_sweep.h"

#include <nlohmann/json.hpp>

#include "pipeline/manifest.h"
#include "pipeline/results_folder.h"
#include "pipeline/sweep/earlier_cells.h"
#include "pipeline/sweep/sweep_cell_key.h"
#include "pipeline/sweep/sweep_part.h"
#include "pipeline/sweep/sweep_timing.h"
#include "pipeline/watch.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;
bool is_part(const ExecuteSweepOptions& options) { return !options.work.shard.whole(); }

// What only an unfinished output needs could not be removed when it was put in place.
bool holds_unfinished(const fs::path& folder, bool is_part) {
  return fs::exists(folder / SweepLog::kOpen) || (!is_part && fs::exists(folder / SweepLog::kFinished));
}

bool holds_part(const fs::path& folder, const SweepPlan& plan, const Shard& shard) {
  if (!fs::exists(folder / "part.json") || !fs::exists(folder / SweepLog::kFinished)) return false;
  const WorkPart there = read_part(folder), wanted = part_of(plan, shard);
  return there.kind == wanted.kind && there.build == wanted.build && there.number == wanted.number &&
         there.of == wanted.of && there.work == wanted.work;
}

// The output holds all that was asked for.
SweepOutcome unchanged(const SweepPlan& plan, const fs::path& output, const ExecuteSweepOptions& options) {
  SweepOutcome outcome;
  outcome.is_part = is_part(options);
  outcome.folder = output;
  outcome.unchanged = true;
  const SweepStripe stripe = stripe_of(plan, options.work.shard);
  for (std::size_t c = 0; c < plan.cells(); ++c)
    if (chunks_in_cell(plan, stripe, c) > 0) outcome.tally.reused[output.string()].push_back(c);
  if (outcome.is_part) return outcome;
  outcome.summary = read_sweep_summary(output);
  outcome.timings = read_sweep_timings(output);
  return outcome;
}

SweepRun run_cells(const SweepPlan& plan, const ResultsFolder& folder, SweepLog& log,
                   const ExecuteSweepOptions& options) {
  std::vector<fs::path> folders = options.work.reuse;
  if (!options.fresh && fs::is_directory(folder.output())) folders.insert(folders.begin(), folder.output());
  EarlierCells earlier(folders);
  SweepRunOptions run;
  if (is_part(options)) run.shard = options.work.shard;
  run.stop_requested = options.stop_requested;
  run.progress = options.progress;
  run.log = &log;
  run.save_every_s = options.save_every_s;
  if (!folders.empty()) run.earlier = [&](std::size_t cell) { return earlier.find(key_of_cell(plan, cell)); };
  return run_sweep(plan, run);
}

void write_outputs(const SweepPlan& plan, const fs::path& folder, const Shard& shard,
                   const SweepOutcome& outcome) {
  if (!outcome.is_part || outcome.summary.interrupted) {
    write_sweep_results(folder, plan, outcome.summary, outcome.timings);
    return;
  }
  if (outcome.timings) write_sweep_timings(folder, *outcome.timings);
  write_part(folder, part_of(plan, shard));
}

SweepOutcome execute_into(const SweepPlan& plan, const ResultsFolder& folder,
                          const ExecuteSweepOptions& options, int threads) {
  const RunningTime start;
  SweepLog log(folder.partial());
  SweepRun run = run_cells(plan, folder, log, options);
  SweepOutcome outcome;
  outcome.is_part = is_part(options);
  outcome.tally = std::move(run.tally);
  const double trials_s = start.seconds();
  const bool is_timed = plan.spec.time_problems > 0 && options.work.shard.number == 1;
  if (is_timed && !run.interrupted) {
    outcome.timings = time_sweep(plan, options.stop_requested, options.timing_progress);
    run.interrupted = !outcome.timings;
  }
  outcome.summary = summary_of(plan, std::move(run.cells), !run.interrupted && !outcome.is_part);
  outcome.summary.interrupted = run.interrupted;
  write_outputs(plan, folder.partial(), options.work.shard, outcome);
  const double wall_s = start.seconds();
  write_run_record(
      folder.partial(),
      {{"trials_s", trials_s}, {"timing_s", wall_s - trials_s}, {"reused", reused_json(plan, outcome.tally)}},
      wall_s, threads);
  return outcome;
}

}  // namespace

SweepOutcome execute_sweep(const SweepPlan& plan, const fs::path& asked, const ExecuteSweepOptions& options) {
  const fs::path output = output_name(asked);
  const bool is_there =
      is_part(options) ? holds_part(output, plan, options.work.shard) : holds_sweep(output, plan);
  if (is_there && !options.fresh && !holds_unfinished(output, is_part(options)))
    return unchanged(plan, output, options);
  const ResultsFolder folder(output, options.fresh ? Kept{} : Kept{SweepLog::kFinished, SweepLog::kOpen});
  SweepOutcome outcome;
  on_threads(options.threads, [&](int threads) { outcome = execute_into(plan, folder, options, threads); });
  outcome.folder = outcome.summary.interrupted ? folder.partial() : folder.output();
  if (!outcome.summary.interrupted)
    folder.put_in_place(outcome.is_part ? Kept{SweepLog::kOpen} : Kept{SweepLog::kFinished, SweepLog::kOpen});
  return outcome;
}

}  // namespace trilat
