// SPDX-License-Identifier: MIT
#include <cmath>

#include <gmock/gmock.h>

#include "reports/claims/claims.h"
#include "reports/render/render.h"
#include "tests/reports/summaries.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

// The row whose number is called so, and whose "how" ends so.
const std::vector<TableValue>& row_of(const Table& table, const std::string& number,
                                      const std::string& how = "") {
  for (const auto& row : table.rows)
    if (row[2].text == number && row[6].text.find(how) != std::string::npos) return row;
  ADD_FAILURE() << number << ", " << how;
  return table.rows.front();
}

TEST(Audit, AveragesOfThePrintedRowsByPencil) {
  const Table table = audit_table();
  const auto& linear = row_of(table, "Table III, average of linear (cm)");
  EXPECT_NEAR(*linear[4].number, (5.3 + 10.5 + 8.6 + 18.3) / 4.0,
              1e-12);  // 10.675, which is 10.7 and not 10.8
  EXPECT_EQ(linear[5].text, "differs");
  const auto& geometric = row_of(table, "Table III, average of geometric (cm)");
  EXPECT_NEAR(*geometric[4].number, 14.05, 1e-12);
  const auto& nonlinear = row_of(table, "Table III, average of nonlinear (cm)");
  EXPECT_NEAR(*nonlinear[4].number, 8.6, 1e-12);
  EXPECT_EQ(nonlinear[5].text, "differs");
}

TEST(Audit, TheAbstractsPercentagesAreThoseOfTheOtherMethodAndOfTwoConventions) {
  const Table table = audit_table();
  const auto& abstract = row_of(table, "abstract, better than linear (%)", "of the error of linear");
  EXPECT_NEAR(*abstract[4].number, 100.0 * (10.8 - 8.7) / 10.8, 1e-9);
  EXPECT_EQ(abstract[5].text, "differs");
  EXPECT_EQ(row_of(table, "text, better than linear (%)", "of the error of linear")[5].text, "differs");
  EXPECT_EQ(row_of(table, "text, better than linear (%)", "of the error of nonlinear")[5].text, "agrees");
  EXPECT_EQ(row_of(table, "text, better than geometric (%)", "of the error of geometric")[5].text, "agrees");
}

TEST(Audit, SharesAndSumsOfTableIvByPencil) {
  const Table table = audit_table();
  const auto& below = row_of(table, "Table IV, clock errors below 2 ms (%)");
  EXPECT_NEAR(*below[4].number, 100.0 * 71740.0 / 71998.0, 1e-9);
  EXPECT_EQ(below[5].text, "differs");
  EXPECT_EQ(*row_of(table, "Table IV, clock samples")[4].number, 71998.0);
  EXPECT_EQ(row_of(table, "Table IV, frames and lost frames")[5].text, "agrees");
  EXPECT_EQ(row_of(table, "Table IV, frames in real time (%)")[5].text, "agrees");
}

TEST(Audit, NothingIsLeftEmpty) {
  for (const Table& table : {audit_table(), errata_table({})})
    for (const auto& row : table.rows) {
      ASSERT_EQ(row.size(), table.columns.size());
      for (const TableValue& value : row)
        EXPECT_THAT(printed(value), Not(testing::AnyOf("", "–"))) << row[2].text;
    }
}

TEST(Errata, AllAreListedAndWithoutAStudyNoEffectIsClaimed) {
  const Table table = errata_table({});
  ASSERT_EQ(table.rows.size(), 21u);
  for (std::size_t k = 0; k < table.rows.size(); ++k)
    EXPECT_EQ(table.rows[k][0].text, "E" + std::to_string(k + 1));
  EXPECT_EQ(table.rows[6][5].text, "its study is not among these results");
  EXPECT_EQ(table.rows[8][5].text, "none on a result");
}

TEST(Errata, TheEffectIsPrintedBesideCorrected) {
  PaperFindings findings;
  findings.errata["E8"] = {{.claim = "E8",
                            .what = "printed stop against nonlinear",
                            .unit = "%",
                            .value = 33.3,
                            .low = 30.0,
                            .high = 36.0,
                            .compared = 0.8}};
  EXPECT_EQ(errata_table(findings).rows[7][5].text,
            "printed stop against nonlinear: 33.3 % (30.0 to 36.0), where both answer (80 % of the samples)");
}

}  // namespace
}  // namespace trilat
