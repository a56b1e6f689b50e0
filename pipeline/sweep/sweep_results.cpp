// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_results.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "pipeline/sweep/earlier_cells.h"
#include "pipeline/sweep/interpretation_search.h"
#include "pipeline/sweep/sweep_cell_key.h"

namespace trilat {
namespace {

std::string manifest_text(const SweepPlan& plan) {
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
  return json_text(json, 1) + "\n";
}

bool has_same_items(const std::filesystem::path& folder, const SweepPlan& plan) {
  const std::vector<DoneItem> there = read_items(folder).items, wanted = items_of(plan);
  return std::equal(there.begin(), there.end(), wanted.begin(), wanted.end(),
                    [](const DoneItem& a, const DoneItem& b) { return a.id == b.id && a.key == b.key; });
}

}  // namespace

SweepSummary summary_of(const SweepPlan& plan, std::vector<SweepCell> cells, bool complete) {
  SweepSummary s;
  s.study = plan.spec.name;
  s.seed = plan.spec.seed;
  s.trials = plan.spec.trials;
  s.max_iterations = plan.spec.max_iterations;
  s.interrupted = !complete;
  s.skipped = plan.skipped;
  s.thresholds = plan.spec.thresholds;
  s.ranges = plan.spec.ranges;
  for (const SweepReading& reading : plan.readings) s.interpretations.push_back(reading.text);
  s.cells = std::move(cells);
  if (plan.spec.search && complete) s.search = search_interpretations(s, printed_table1());
  return s;
}

bool holds_sweep(const std::filesystem::path& folder, const SweepPlan& plan) {
  for (const char* file : {"manifest.json", "summary.json", "items.json", "run.json"})
    if (!std::filesystem::exists(folder / file)) return false;
  return read_file(folder / "manifest.json") == manifest_text(plan) &&
         (plan.spec.time_problems == 0 || read_sweep_timings(folder)) && has_same_items(folder, plan);
}

void write_sweep_results(const std::filesystem::path& folder, const SweepPlan& plan,
                         const SweepSummary& summary, const std::optional<SweepTimings>& timings) {
  write_file(folder / "manifest.json", manifest_text(plan));
  write_sweep_summary(folder, summary);
  if (timings) write_sweep_timings(folder, *timings);
  if (!summary.interrupted) write_items(folder, items_of(plan));
}

Json reused_json(const SweepPlan& plan, const SweepTally& tally) {
  Json reused = Json::array();
  for (const auto& [folder, cells] : tally.reused) {
    Json ids = Json::array();
    for (const std::size_t cell : cells) ids.push_back(id_of_cell(plan, cell));
    reused.push_back({{"from", folder}, {"items", ids}});
  }
  return reused;
}

}  // namespace trilat
