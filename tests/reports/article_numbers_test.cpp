// SPDX-License-Identifier: MIT
#include <algorithm>
#include <limits>
#include <set>

#include <gmock/gmock.h>

#include "reports/render/latex.h"

namespace trilat {
namespace {

using testing::HasSubstr;

Table wrist_table() {
  Table table;
  table.id = "table3";
  table.columns = {{"joint", "joint", true},
                   {"method", "method", true},
                   interval_column("ours (cm)", "mae_cm"),
                   {"n", "n", false}};
  const auto row = [](const char* method, double mae_cm, double low_cm) {
    return std::vector<TableValue>{TableValue::of("wrist"), TableValue::of(method),
                                   number_cell(2, mae_cm, low_cm, 9.096), TableValue::of(1200.0, 0)};
  };
  table.rows = {row("linear", 8.5, std::numeric_limits<double>::quiet_NaN()),
                row("nonlinear, 3 sensors", 8.014, 6.9)};
  return table;
}

std::string value_of(const std::vector<ArticleNumber>& numbers, const std::string& name) {
  const auto found = std::ranges::find_if(numbers, [&](const auto& number) { return number.name == name; });
  return found == numbers.end() ? "no such macro" : found->value;
}

TEST(ArticleNumbers, AreNamedByTableRowAndColumnWithDigitsWrittenOut) {
  const auto numbers = article_numbers({wrist_table()});
  EXPECT_EQ(numbers.size(), 6u);  // two a row, and an interval
  EXPECT_EQ(value_of(numbers, "trilatTableThreeWristNonlinearThreeSensorsMaeCm"), "8.01");
  EXPECT_EQ(value_of(numbers, "trilatTableThreeWristNonlinearThreeSensorsN"), "1200");
}

TEST(ArticleNumbers, AnIntervalIsAMacroOfItsOwn) {
  const auto numbers = article_numbers({wrist_table()});
  EXPECT_EQ(value_of(numbers, "trilatTableThreeWristNonlinearThreeSensorsMaeCmInterval"), "6.90 to 9.10");
}

TEST(ArticleNumbers, WhatIsNoNumberIsADash) {
  const auto numbers = article_numbers({wrist_table()});
  EXPECT_EQ(value_of(numbers, "trilatTableThreeWristLinearMaeCmInterval"), "--");
}

TEST(ArticleNumbers, HoldLettersOnlyAndDiffer) {
  Table first = wrist_table(), second = wrist_table();
  second.rows.push_back(second.rows.front());  // rows that no cell tells apart are numbered
  second.rows.push_back(second.rows.front());
  Table third = wrist_table();
  third.id = "table-3";
  const auto numbers = article_numbers({first, second, third});
  std::set<std::string> names;
  for (const ArticleNumber& number : numbers) {
    EXPECT_EQ(number.name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"),
              std::string::npos)
        << number.name;
    EXPECT_TRUE(names.insert(number.name).second) << number.name;
  }
  EXPECT_TRUE(names.contains("trilatTableThreeWristLinearMaeCmSecond"));
  EXPECT_TRUE(names.contains("trilatTableThreeRowFourMaeCm"));
}

TEST(ArticleNumbers, ARowIsNamedByAsFewCellsAsTellItApart) {
  Table table = wrist_table();
  table.columns[1].name = "range";
  table.rows[0][0] = TableValue::of("0-5");
  table.rows[1][0] = TableValue::of("5-15");
  EXPECT_EQ(value_of(article_numbers({table}), "trilatTableThreeFiveOneFiveMaeCm"), "8.01");
}

TEST(ArticleNumbers, AreNotNamedByWhatWasMeasured) {
  Table table = wrist_table();
  table.rows[1][1] = TableValue::of("linear");
  EXPECT_EQ(value_of(article_numbers({table}), "trilatTableThreeRowTwoMaeCm"), "8.01");
  table.columns[2].is_key = true;
  EXPECT_EQ(value_of(article_numbers({table}), "trilatTableThreeWristLinearEightZeroOneN"), "1200");
}

TEST(ArticleNumbers, BecomeOneNewcommandEach) {
  EXPECT_THAT(latex_of(std::vector<ArticleNumber>{{"trilatN", "12"}}),
              HasSubstr("\n\\newcommand{\\trilatN}{12}\n"));
}

}  // namespace
}  // namespace trilat
