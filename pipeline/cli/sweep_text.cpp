// SPDX-License-Identifier: MIT
#include "pipeline/cli/sweep_text.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/cli/verbs.h"
#include "reports/statuses_text.h"
#include "reports/sweep_tables.h"

namespace trilat {
namespace {

struct ShareOfPlan {
  std::uint64_t cells = 0, trials = 0;
};

ShareOfPlan share_of(const SweepPlan& plan, const Shard& shard) {
  const SweepStripe stripe = stripe_of(plan, shard);
  const std::uint64_t chunks = chunks_per_cell(plan);
  ShareOfPlan share;
  for (std::size_t c = 0; c < plan.cells(); ++c) {
    const std::uint64_t count = chunks_in_cell(plan, stripe, c);
    if (count == 0) continue;
    ++share.cells;
    share.trials += count * kChunkTrials;
    const bool has_last = stripe.chunk(stripe.turns_before((c + 1) * chunks) - 1) == (c + 1) * chunks - 1;
    if (has_last) share.trials -= chunks * kChunkTrials - plan.spec.trials;
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
  const std::string digits =
      cell.digits_trials > 0 ? fmt::format("{:4.1f} digits, ", cell.mean_digits) : std::string();
  fmt::print(
      "  C {:<6g} error {:>4g} to {:>2g} cm: {:8.3f} cm (axes {:.3f}), start {:.3f} cm, {:8.1f} "
      "iterations, {}{:.2f} % answered\n",
      s.thresholds[cell.threshold], 100.0 * range.low_m, 100.0 * range.high_m, 100.0 * cell.mae_m,
      100.0 * cell.axis_mean_mae_m(), 100.0 * cell.start_mae_m, cell.mean_iterations, digits,
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

Json result_json(const SweepOutcome& outcome) {
  const SweepSummary& s = outcome.summary;
  std::uint64_t asked = 0, answered = 0;
  for (const SweepCell& cell : s.cells) {
    asked += cell.asked;
    answered += cell.answered;
  }
  return {{"results", outcome.folder.string()},
          {"simulated", true},
          {"interpretations", s.interpretations.size()},
          {"cells", s.cells.size()},
          {"trials", asked},
          {"answered", answered},
          {"timed", outcome.timings.has_value()},
          {"interrupted", s.interrupted},
          {"unchanged", outcome.unchanged},
          {"items", outcome.tally.all()},
          {"items_computed", outcome.tally.computed.size()},
          {"items_continued", outcome.tally.continued.size()},
          {"items_reused", outcome.tally.reused_count()}};
}

}  // namespace

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
          {{"shard", name_of(shard)}, {"shard_cells", share.cells}, {"shard_trials", share.trials}});
    fmt::print("{}\n", json_text(document, 2));
    return kDone;
  }
  fmt::print(
      "study {} (simulated): {} interpretations x {} thresholds x {} error ranges = {} cells x {} "
      "trials = {} trials; {} combinations are skipped\n",
      plan.spec.name, plan.readings.size(), plan.spec.thresholds.size(), plan.spec.ranges.size(),
      plan.cells(), plan.spec.trials, trials, plan.skipped);
  for (const SweepRig& rig : plan.spec.rigs) {
    fmt::print("rig {}:", rig.name);
    for (const auto& s : rig.sensors_m) fmt::print(" ({:.3g}, {:.3g}, {:.3g}) m", s[0], s[1], s[2]);
    fmt::print("\n");
  }
  for (const SweepReading& reading : plan.readings) fmt::print("  {}\n", reading.text.id);
  if (!shard.whole())
    fmt::print("shard {} computes {} trials in {} cells: one chunk of {} in {}\n", name_of(shard),
               share.trials, share.cells, kChunkTrials, shard.of);
  return kDone;
}

void print_sweep(const SweepOutcome& outcome, const Shard& shard, bool json) {
  if (json) {
    Json document = result_json(outcome);
    if (outcome.is_part) document["shard"] = name_of(shard);
    fmt::print("{}\n", json_text(document, 2));
    return;
  }
  if (!outcome.is_part) {
    print_cells(outcome.summary);
    for (const std::string& sentence : search_sentences(outcome.summary)) fmt::print("{}\n", sentence);
  }
  fmt::print("{}: {}\n", outcome.is_part ? "shard " + name_of(shard) : "results", outcome.folder.string());
}

void note_sweep_tally(const SweepOutcome& outcome) {
  const SweepTally& tally = outcome.tally;
  const std::string folder = outcome.folder.string();
  if (outcome.unchanged) {
    fmt::print(stderr, "trilat: nothing changed; {} holds all {} cells already\n", folder, tally.all());
    return;
  }
  if (!tally.continued.empty())
    fmt::print(stderr, "trilat: went on from a run that was stopped: {} cells of {} were done or begun\n",
               tally.continued.size(), tally.all());
  if (!tally.reused.empty())
    fmt::print(stderr, "trilat: {} cells of {} are those of earlier results; {}/run.json lists them\n",
               tally.reused_count(), tally.all(), folder);
  if (outcome.summary.interrupted)
    fmt::print(stderr, "trilat: interrupted; what was finished has been kept in {}\n", folder);
}

}  // namespace trilat
