// SPDX-License-Identifier: MIT
// Input and output of `trilat run` for threshold sweeps.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/results/table.h"
#include "pipeline/cli/kinds.h"
#include "pipeline/sweep/sweep_study.h"

namespace trilat {
namespace {

// A shard's share of a sweep.
struct ShareOfPlan {
  std::uint64_t items = 0, trials = 0;
};

ShareOfPlan share_of(const SweepPlan& plan, const Shard& shard) {
  const std::vector<SweepItem> items = items_of(plan);
  std::vector<double> costs;
  for (const SweepItem& item : items) costs.push_back(static_cast<double>(trials_in(plan, item)));
  const std::vector<std::uint64_t> owner = shards_of(costs, shard.of);
  ShareOfPlan share;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (owner[i] != shard.number) continue;
    ++share.items;
    share.trials += trials_in(plan, items[i]);
  }
  return share;
}

void print_cell(const SweepSummary& s, const SweepCell& cell) {
  const auto& range = s.ranges[cell.range];
  if (cell.answered == 0) {
    fmt::print("  C {:<6g} error {:>4g} to {:>2g} cm: no trial answered: {}\n", s.thresholds[cell.threshold],
               100.0 * range.low_m, 100.0 * range.high_m, statuses_text(cell.statuses, cell.asked));
    return;
  }
  fmt::print(
      "  C {:<6g} error {:>4g} to {:>2g} cm: {:8.3f} cm (axes {:.3f}), start {:.3f} cm, {:8.1f} iterations, "
      "{:.2f} % answered\n",
      s.thresholds[cell.threshold], 100.0 * range.low_m, 100.0 * range.high_m, 100.0 * cell.mae_m,
      100.0 * cell.axis_mean_mae_m(), 100.0 * cell.start_mae_m, cell.mean_iterations,
      100.0 * static_cast<double>(cell.answered) / static_cast<double>(cell.asked));
}

void print_cells(const SweepSummary& s) {
  constexpr std::size_t kMostPrinted = 120;
  fmt::print("{} (simulated, {} trials a cell)\n", s.study, s.trials);
  std::size_t printed = 0;
  for (const SweepCell& cell : s.cells) {
    if (cell.asked == 0) continue;
    if (++printed > kMostPrinted) break;
    if (cell.threshold == 0 && cell.range == 0) fmt::print("{}\n", s.interpretations[cell.interpretation].id);
    print_cell(s, cell);
  }
  if (printed > kMostPrinted) fmt::print("  … all {} cells are in summary.json\n", s.cells.size());
}

int print_sweep_plan(const SweepPlan& plan, const Shard& shard, bool json) {
  const std::uint64_t trials = plan.cells() * plan.spec.trials;
  const ShareOfPlan share = share_of(plan, shard);
  if (json) {
    Json rigs = Json::array(), readings = Json::array();
    for (const SweepRig& rig : plan.spec.rigs)
      rigs.push_back({{"name", rig.name}, {"sensors_m", rig.sensors_m}});
    for (const SweepReading& reading : plan.readings) readings.push_back(reading.text.id);
    Json document{
        {"study", plan.spec.name}, {"simulated", true},     {"rigs", rigs},    {"interpretations", readings},
        {"skipped", plan.skipped}, {"cells", plan.cells()}, {"trials", trials}};
    if (!shard.whole())
      document.update(
          {{"shard", name_of(shard)}, {"shard_items", share.items}, {"shard_trials", share.trials}});
    fmt::print("{}\n", json_text(document, 2));
    return kDone;
  }
  fmt::print(
      "study {} (simulated): {} interpretations x {} thresholds x {} error ranges = {} cells x {} trials = "
      "{} trials; {} combinations are skipped\n",
      plan.spec.name, plan.readings.size(), plan.spec.thresholds.size(), plan.spec.ranges.size(),
      plan.cells(), plan.spec.trials, trials, plan.skipped);
  for (const SweepRig& rig : plan.spec.rigs) {
    fmt::print("rig {}:", rig.name);
    for (const auto& s : rig.sensors_m) fmt::print(" ({:.3g}, {:.3g}, {:.3g}) m", s[0], s[1], s[2]);
    fmt::print("\n");
  }
  for (const SweepReading& reading : plan.readings) fmt::print("  {}\n", reading.text.id);
  if (!shard.whole())
    fmt::print("shard {} computes {} trials in {} items\n", name_of(shard), share.trials, share.items);
  return kDone;
}

}  // namespace

OpenedStudy open_sweep(const RunArguments& arguments, const Json& study) {
  const std::string place = arguments.study.string();
  const auto plan = std::make_shared<const SweepPlan>(make_sweep_plan(parse_sweep(study, place), place));
  return {.plan = [plan](const Watch&) { return sweep_study(*plan); },
          .print_plan = [plan](const Shard& shard, bool json,
                               const Watch&) { return print_sweep_plan(*plan, shard, json); }};
}

int print_sweep(const std::filesystem::path& results, Json document, const Shown& shown) {
  const SweepSummary s = read_results<SweepSummary>(results);
  if (shown.json) {
    std::uint64_t asked = 0, answered = 0;
    for (const SweepCell& cell : s.cells) {
      asked += cell.asked;
      answered += cell.answered;
    }
    document.update(Json{{"results", results.string()},
                         {"simulated", true},
                         {"interpretations", s.interpretations.size()},
                         {"cells", s.cells.size()},
                         {"trials", asked},
                         {"answered", answered}});
    fmt::print("{}\n", json_text(document, 2));
    return kDone;
  }
  print_cells(s);
  const StoredTables stored = read_beside<StoredTables>(results).value();
  for (const std::string& finding : stored.findings) fmt::print("{}\n", finding);
  fmt::print("results: {}\n", results.string());
  return kDone;
}

}  // namespace trilat
