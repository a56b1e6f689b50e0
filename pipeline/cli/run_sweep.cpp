// SPDX-License-Identifier: MIT
// `trilat run` of a threshold sweep.
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/sweep/execute_sweep.h"
#include "reports/statuses_text.h"
#include "reports/sweep_tables.h"

namespace trilat {
namespace {

int print_plan(const SweepPlan& plan, bool json) {
  const std::uint64_t trials = plan.cells() * plan.spec.trials;
  if (json) {
    Json rigs = Json::array(), readings = Json::array();
    for (const SweepRig& rig : plan.spec.rigs)
      rigs.push_back({{"name", rig.name}, {"sensors_m", rig.sensors_m}});
    for (const SweepReading& reading : plan.readings) readings.push_back(reading.text.id);
    const Json document{
        {"study", plan.spec.name}, {"simulated", true},     {"rigs", rigs},    {"interpretations", readings},
        {"skipped", plan.skipped}, {"cells", plan.cells()}, {"trials", trials}};
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
  return kDone;
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
          {"interrupted", s.interrupted}};
}

}  // namespace

int run_sweep_study(const RunArguments& arguments, const Json& study) {
  if (!arguments.campaign.empty())
    throw InputError("--campaign", "is of no use: a threshold sweep makes its own trials and needs none");
  if (!arguments.calibration.empty())
    throw InputError("--calibration", "is of no use: a threshold sweep places its own sensors");
  if (arguments.cross_check)
    throw InputError("--cross-check",
                     "is for studies of kind accuracy; a threshold sweep counts the digits "
                     "that agree with the exact minimum");
  const std::string place = arguments.study.string();
  const SweepPlan plan = make_sweep_plan(parse_sweep(study, place), place);
  if (arguments.dry_run) return print_plan(plan, arguments.json);
  if (arguments.output.empty()) throw InputError("--output", "is missing: where should the results go?");
  SweepOutcome outcome;
  {
    Progress sweeping("sweeping");
    std::optional<Progress> timing;  // its clock starts when it is first shown
    const auto show_timing = [&](double share) {
      if (!timing) timing.emplace("timing");
      timing->set(share);
    };
    outcome = execute_sweep(
        plan, arguments.output,
        {arguments.threads, stop_requested, [&](double share) { sweeping.set(share); }, show_timing});
  }
  if (arguments.json) {
    fmt::print("{}\n", json_text(result_json(outcome), 2));
  } else {
    print_cells(outcome.summary);
    for (const std::string& sentence : search_sentences(outcome.summary)) fmt::print("{}\n", sentence);
    fmt::print("results: {}\n", outcome.folder.string());
  }
  if (!outcome.summary.interrupted) return kDone;
  fmt::print(stderr, "trilat: interrupted; what was finished has been kept in {}\n", outcome.folder.string());
  return kItemsFailed;
}

}  // namespace trilat
