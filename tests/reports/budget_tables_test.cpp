// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/base/units.h"
#include "reports/figures/figures.h"
#include "reports/render/render.h"
#include "reports/tables/tables.h"
#include "reports/write_report.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

BudgetRow row_of(const std::string& source, double rmse_m, const std::string& alignment = "none") {
  return {source, "mean", "walking", "wrist", alignment, std::isnan(rmse_m) ? 0u : 10u, rmse_m, rmse_m};
}

// 1 cm are left with none; jitter makes them sqrt(10) cm and bias 4 cm, so that the sum is 5 cm.
BudgetSummary pencil_budget() {
  BudgetSummary s;
  s.study = "budget";
  s.campaign = "paper";
  s.seed = 9;
  s.participants = 2;
  s.calibration_sigma_m = 0.005;
  s.calibration_sigma_rad = 0.2 * kRadPerDegree;
  s.sources = {"none", "jitter", "bias", "all"};
  s.descriptions = {"nothing", "noise", "what is systematic", "everything"};
  s.rows = {row_of("none", 0.01), row_of("jitter", 0.01 * std::sqrt(10.0)), row_of("bias", 0.04),
            row_of("all", 0.04)};
  return s;
}

std::size_t budget_column(const Table& table, const std::string& key) {
  for (std::size_t c = 0; c < table.columns.size(); ++c)
    if (table.columns[c].key == key) return c;
  ADD_FAILURE() << key;
  return 0;
}

double budget_number(const Table& table, const std::string& key) {
  return *table.rows.at(0).at(budget_column(table, key)).number;
}

TEST(BudgetTables, SquaresAddAndWhatIsAlwaysThereCountsOnce) {
  const std::vector<Table> tables = budget_tables(pencil_budget());
  ASSERT_EQ(tables.size(), 2u);
  const Table& table = tables[0];
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_NEAR(budget_number(table, "none_rmse_cm"), 1.0, 1e-12);
  EXPECT_NEAR(budget_number(table, "bias_rmse_cm"), 4.0, 1e-12);
  EXPECT_NEAR(budget_number(table, "sum_rmse_cm"), 5.0, 1e-12);
  EXPECT_NEAR(budget_number(table, "observed_rmse_cm"), 4.0, 1e-12);
  EXPECT_NEAR(budget_number(table, "sum_to_observed"), 1.25, 1e-12);
  EXPECT_THAT(table.title, HasSubstr("simulated"));
  EXPECT_THAT(table.title, HasSubstr("2 participants, seed 9"));
  EXPECT_THAT(markdown_of(table), HasSubstr("Calibration: 5 mm and 0.2 degrees an axis"));
}

TEST(BudgetTables, TheSumIsNotKnownWhenASourceIsNot) {
  for (const std::size_t unknown : {0u, 1u}) {
    BudgetSummary s = pencil_budget();
    s.rows[unknown].rmse_m = kNoNumber;
    const Table table = budget_tables(s)[0];
    EXPECT_TRUE(std::isnan(budget_number(table, "sum_rmse_cm"))) << unknown;
    EXPECT_TRUE(std::isnan(budget_number(table, "sum_to_observed"))) << unknown;
    s.rows.erase(s.rows.begin() + static_cast<std::ptrdiff_t>(unknown));
    EXPECT_TRUE(std::isnan(budget_number(budget_tables(s)[0], "sum_rmse_cm"))) << "missing " << unknown;
  }
}

TEST(BudgetTables, AMethodThatNeverAnswersIsADashThroughout) {
  BudgetSummary s = pencil_budget();
  for (BudgetRow& row : s.rows) row.rmse_m = kNoNumber;
  const Table table = budget_tables(s)[0];
  for (std::size_t c = 2; c < table.columns.size(); ++c)
    EXPECT_EQ(printed(table.rows[0][c]), printed(TableValue::of(kNoNumber, 1))) << table.columns[c].key;
  EXPECT_THAT(markdown_of(table), Not(HasSubstr("nan")));
}

// An average of groups has a mean error and no RMSE.
TEST(BudgetTables, TheAverageOfTheGroupsIsLeftOut) {
  BudgetSummary s = pencil_budget();
  const auto rows = s.rows;
  for (BudgetRow row : rows) {
    row.group = kAverageGroup;
    row.rmse_m = kNoNumber;
    s.rows.push_back(row);
  }
  EXPECT_EQ(budget_tables(s)[0].rows.size(), 1u);
}

TEST(BudgetTables, EveryConditionAndAlignmentHasATableOfItsOwn) {
  BudgetSummary s = pencil_budget();
  const auto rows = s.rows;
  for (BudgetRow row : rows) {
    row.alignment = "mean";
    s.rows.push_back(row);
    row.condition = "standing";
    s.rows.push_back(row);
  }
  const std::vector<Table> tables = budget_tables(s);
  EXPECT_EQ(tables.back().id, "sources");
  EXPECT_EQ(tables.back().rows.size(), 4u);
  std::vector<std::string> ids;
  for (const Table& table : tables) {
    EXPECT_FALSE(table.rows.empty()) << table.id;
    EXPECT_EQ(std::ranges::count(ids, table.id), 0) << table.id;
    ids.push_back(table.id);
  }
  EXPECT_EQ(ids.size(), 4u);  // no table of a condition with an alignment that it does not have
}

TEST(BudgetTables, TheReportOfABudgetHoldsThem) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "results");
  write_results(folder / "results", pencil_budget());
  const ReportFiles report = write_report({folder / "results"}, folder / "report");
  EXPECT_EQ(report.tables, 2u);
  EXPECT_EQ(report.figures, 0u);
  const std::string markdown = read_file(folder / "report/report.md");
  EXPECT_THAT(markdown, HasSubstr("Error budget of paper, **simulated**: 2 participants, seed 9."));
  EXPECT_THAT(markdown, HasSubstr("5.00"));
  EXPECT_THAT(markdown, HasSubstr("Squares of independent errors add"));
}

}  // namespace
}  // namespace trilat
