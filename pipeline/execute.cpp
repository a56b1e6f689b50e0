// SPDX-License-Identifier: MIT
#include "pipeline/execute.h"

#include <chrono>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/manifest.h"
#include "pipeline/plan.h"
#include "pipeline/runner.h"
#include "pipeline/summarise.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void check_output(const std::filesystem::path& output) {
  namespace fs = std::filesystem;
  if (!fs::exists(output)) return;
  const bool empty = fs::is_directory(output) && fs::is_empty(output);
  const bool results = fs::exists(output / "summary.json") && fs::exists(output / "manifest.json") &&
                       fs::exists(output / "samples.h5");
  if (!empty && !results)
    throw InputError(output.string(), "exists and is not a results folder; choose another name or remove it");
}

void put_in_place(const std::filesystem::path& partial, const std::filesystem::path& output) {
  namespace fs = std::filesystem;
  const fs::path old = partial.string() + ".old";
  std::error_code error;
  fs::remove_all(old, error);
  if (fs::exists(output)) fs::rename(output, old, error);
  if (!error) fs::rename(partial, output, error);
  if (error) throw InputError(output.string(), "cannot be put in place: " + error.message());
  fs::remove_all(old, error);
}

ResultsSummary execute_into(const StudySpec& study, const Campaign& campaign,
                            const std::filesystem::path& folder, const ExecuteOptions& options, int threads) {
  const Clock::time_point start = Clock::now();
  const Plan plan = make_plan(study, campaign);
  SamplesFile samples = SamplesFile::create(folder / "samples.h5", samples_header(plan));
  RunOutcome outcome =
      run_plan(plan, samples, {options.cross_check, options.stop_requested, options.progress});
  const Clock::time_point summary_start = Clock::now();
  const ResultsSummary summary = summarise(plan, outcome, samples);
  outcome.times.summarise_s = seconds_since(summary_start);
  samples.finish();
  write_manifest(folder, plan, options.stop_requested);
  write_summary(folder, summary);
  write_run_record(folder, outcome.times, seconds_since(start), threads);
  return summary;
}

}  // namespace

ResultsSummary execute_study(const StudySpec& study, const Campaign& campaign,
                             const std::filesystem::path& folder, const ExecuteOptions& options) {
  const std::filesystem::path output = folder.has_filename() ? folder : folder.parent_path();  // "results/"
  check_output(output);
  const std::filesystem::path partial = partial_name(output);
  std::filesystem::remove_all(partial);
  make_folder(partial);
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  ResultsSummary summary;
  arena.execute([&] { summary = execute_into(study, campaign, partial, options, threads); });
  put_in_place(partial, output);
  return summary;
}

}  // namespace trilat
