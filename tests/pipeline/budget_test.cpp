// SPDX-License-Identifier: MIT
#include <cmath>
#include <map>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/base/units.h"
#include "datasets/results/declared_parameters.h"
#include "datasets/results/studies/budget_summary.h"
#include "datasets/synthetic/error_sources.h"
#include "pipeline/budget/budget_study.h"
#include "reports/tables/tables.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kBudgetMethods =
    R"("alignments": ["none"], "clock": "stated", "methods": [{"method": "mean"}, {"method": "nonlinear"}])";

std::string budget_text(const std::string& members) {
  return R"({"format": "trilat.study", "version": 1, "kind": "error_budget", "name": "budget", )" + members +
         "}";
}

SimulationSpec tracked_walk(std::uint64_t participants, double duration_s) {
  SimulationSpec spec = walking_spec(participants, duration_s);
  spec.body_tracker = default_body_tracker();
  return spec;
}

BudgetSpec budget_of(const std::string& members, const SimulationSpec& simulation) {
  return parse_budget(parse_json(budget_text(members), "budget.json"), "budget.json", {}, simulation);
}

BudgetSummary evaluate(const BudgetSpec& spec, const std::filesystem::path& output, int threads = 2) {
  run_study(budget_study(spec), output, {.threads = threads});
  return read_results<BudgetSummary>(output);
}

TEST(Budget, TheSumOfTheSourcesIsWhatAllOfThemTogetherGive) {
  const ScratchFolder folder;
  const BudgetSummary s = evaluate(budget_of(kBudgetMethods, tracked_walk(4, 4.0)), folder / "results");
  EXPECT_EQ(s.sources.size(), error_sources().size());
  EXPECT_EQ(s.rows.size(), error_sources().size() * 2u * 4u);  // methods and groups
  std::map<std::string, double> none_m2, sum_m2, observed_m;
  for (const BudgetRow& row : s.rows) {
    if (row.method != "mean") continue;
    EXPECT_GT(row.n, 0u) << row.source << " " << row.group;
    EXPECT_TRUE(std::isfinite(row.rmse_m)) << row.source << " " << row.group;
    if (row.source == "none") {
      EXPECT_LT(row.rmse_m, 0.003) << row.group;  // interpolation of a hand between frames
    }
    const double m2 = row.rmse_m * row.rmse_m;
    if (row.source == "none") none_m2[row.group] = m2;
    if (row.source == "all")
      observed_m[row.group] = row.rmse_m;
    else  // what is always there counts once
      sum_m2[row.group] += row.source == "none" ? m2 : m2 - none_m2[row.group];
  }
  for (const auto& [group, m2] : sum_m2) {
    const double ratio = std::sqrt(m2) / observed_m.at(group);
    EXPECT_GT(ratio, 0.95) << group;  // without a source of half the variance it would be 0.9 at most
    EXPECT_LT(ratio, 1.3) << group;   // of few persons, whose biases cancel by chance
  }
  EXPECT_EQ(read_file(folder / "results/summary.json").find("NaN"), std::string::npos);
}

// Markers that do not move at all are measured all the same.
TEST(Budget, APersonWhoStandsStillHasOneToo) {
  const ScratchFolder folder;
  SimulationSpec spec = tracked_walk(1, 1.0);
  spec.activities[0].activity = Activity::standing;
  const BudgetSummary s = evaluate(budget_of(kBudgetMethods, spec), folder / "results");
  for (const BudgetRow& row : s.rows)
    if (row.source == "none") {
      EXPECT_LT(row.mae_m, 2e-5) << row.group;
    }
}

TEST(Budget, ATakeThatFailsSaysWhy) {
  const ScratchFolder folder;
  SimulationSpec spec = tracked_walk(1, 3.0);
  spec.mocap.gap_share = 1.0;
  const std::string message =
      message_of([&] { evaluate(budget_of(kBudgetMethods, spec), folder / "results"); });
  EXPECT_THAT(message,
              AllOf(HasSubstr("with the error \"mocap\" alone"), HasSubstr("holds no ground truth")));
  EXPECT_FALSE(std::filesystem::exists(folder / "results/summary.json"));
}

std::string budget_refusal(const std::string& members,
                           const SimulationSpec& simulation = tracked_walk(1, 1.0)) {
  return message_of([&] { budget_of(members, simulation); });
}

TEST(BudgetSpec, ReplacesSeedAndParticipantsOfTheSimulation) {
  const SimulationSpec simulation = tracked_walk(7, 1.0);
  const BudgetSpec as_given = budget_of(kBudgetMethods, simulation);
  EXPECT_EQ(as_given.simulation.participants, 7u);
  EXPECT_EQ(as_given.simulation.seed, simulation.seed);
  const BudgetSpec replaced =
      budget_of(std::string(R"("participants": 2, "seed": 99, )") + kBudgetMethods, simulation);
  EXPECT_EQ(replaced.simulation.participants, 2u);
  EXPECT_EQ(replaced.simulation.seed, 99u);
}

// Before anything is simulated, and so also in a dry run.
TEST(BudgetSpec, WhatTheSimulationDoesNotHaveIsRefusedAtOnce) {
  const std::string good = kBudgetMethods;
  EXPECT_THAT(budget_refusal(good + R"(, "conditions": ["walking", "flying"])"),
              AllOf(HasSubstr("budget.json /conditions: has \"flying\""), HasSubstr("\"walking\"")));
  EXPECT_THAT(budget_refusal(good + R"(, "reference": "magic")"), HasSubstr("is \"magic\""));
  EXPECT_THAT(
      budget_refusal(good + R"(, "sensors": ["k1", "k9"])"),
      AllOf(HasSubstr("budget.json /sensors: has \"k9\""), HasSubstr("\"k1\", \"k2\", \"k3\", \"k4\"")));
  EXPECT_THAT(budget_refusal(R"("methods": [{"method": "mean", "sensors": ["k9"]}])"), HasSubstr("k9"));
  EXPECT_EQ(budget_refusal(
                good + R"(, "conditions": ["walking"], "reference": "nonlinear", "sensors": ["k1", "k4"])"),
            "no error");
}

}  // namespace
}  // namespace trilat
