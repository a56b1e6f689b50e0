// SPDX-License-Identifier: MIT
#include "pipeline/sweep/merge_sweep.h"

#include <algorithm>
#include <chrono>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "pipeline/manifest.h"
#include "pipeline/results_folder.h"
#include "pipeline/sweep/sweep_cell_key.h"
#include "pipeline/sweep/sweep_part.h"
#include "pipeline/sweep/sweep_part_file.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kBufferBytes = std::size_t{1} << 26;  // of all parts together

class Merger {
 public:
  Merger(const SweepPlan& plan, std::span<const FoundPart> parts) : plan_(plan) {
    const std::size_t bytes = std::clamp<std::size_t>(kBufferBytes / parts.size(), 1u << 10, 1u << 18);
    for (const FoundPart& found : parts) {
      files_.emplace_back(found.folder, bytes);
      stripes_.push_back(stripe_of(plan, {found.part.number, found.part.of}));
    }
  }

  SweepCell cell(std::size_t number) {
    const std::string key = key_of_cell(plan_, number);
    SweepTotals totals;
    std::optional<SweepRecord::Reused> reused;
    bool is_computed = false;
    for (std::size_t p = 0; p < files_.size(); ++p) {
      const std::uint64_t chunks = chunks_in_cell(plan_, stripes_[p], number);
      if (chunks == 0) continue;
      const SweepRecord& record = record_of(p, number, key);
      if (record.reused ? is_computed : reused.has_value())
        refuse(p, number, "is computed in one part and reused in another; give all shards the same --reuse");
      if (record.reused) {
        reused = record.reused;
      } else {
        is_computed = true;
        if (record.chunks != chunks) refuse(p, number, "is not all that the shard has of it");
        totals.add(record.totals);
      }
      files_[p].take();
    }
    if (is_computed && totals.counts.asked != plan_.spec.trials)
      refuse(0, number, "and the other parts do not add up to its trials");
    return with_place(plan_, reused ? reused->cell : totals.cell(), number);
  }

  void check_ends() {
    for (SweepPartFile& file : files_)
      if (file.next() != nullptr)
        throw InputError(file.path().string(), "holds more than the cells of its shard");
  }

 private:
  const SweepRecord& record_of(std::size_t part, std::size_t cell, const std::string& key) {
    const SweepRecord* record = files_[part].next();
    if (record == nullptr || record->cell != cell || record->key != key ||
        record->shard != stripes_[part].shard)
      refuse(part, cell, "is missing");
    return *record;
  }

  [[noreturn]] void refuse(std::size_t part, std::size_t cell, const std::string& problem) const {
    throw InputError(files_[part].path().string(), "cell " + id_of_cell(plan_, cell) + " " + problem);
  }

  const SweepPlan& plan_;
  std::vector<SweepPartFile> files_;
  std::vector<SweepStripe> stripes_;
};

std::vector<SweepCell> merged_cells(const SweepPlan& plan, std::span<const FoundPart> parts,
                                    const MergeSweepOptions& options) {
  Merger merger(plan, parts);
  std::vector<SweepCell> cells;
  for (std::size_t c = 0; c < plan.cells(); ++c) {
    if (options.stop_requested && options.stop_requested()) throw Interrupted();
    cells.push_back(merger.cell(c));
    if (options.progress) options.progress(static_cast<double>(c + 1) / static_cast<double>(plan.cells()));
  }
  merger.check_ends();
  return cells;
}

std::optional<SweepTimings> timings_of(const SweepPlan& plan, const FoundPart& first) {
  if (plan.spec.time_problems == 0) return std::nullopt;
  std::optional<SweepTimings> timings = read_sweep_timings(first.folder);
  if (!timings) throw InputError(first.folder.string(), "holds no timings, which the first shard takes");
  return timings;
}

}  // namespace

SweepOutcome merge_sweep(std::span<const FoundPart> parts, const std::filesystem::path& output,
                         const MergeSweepOptions& options) {
  const Clock::time_point start = Clock::now();
  const FoundPart& first = parts.front();
  const SweepPlan plan = plan_of(first.part, (first.folder / "part.json").string());
  const ResultsFolder folder(output);
  SweepOutcome outcome;
  outcome.timings = timings_of(plan, first);
  outcome.summary = summary_of(plan, merged_cells(plan, parts, options), true);
  outcome.folder = folder.output();
  write_sweep_results(folder.partial(), plan, outcome.summary, outcome.timings);
  const double wall_s = std::chrono::duration<double>(Clock::now() - start).count();
  write_run_record(folder.partial(), {{"parts", parts.size()}}, wall_s, 1);
  folder.put_in_place();
  return outcome;
}

}  // namespace trilat
