// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "reports/figures/figures.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

TwinsSummary summary() {
  TwinsSummary s{"twins", "two sensors", 1, 16, {}};
  s.rows = {{"fitted", "45 degrees", "standing", "head", 0.04, 0.06, 0.07, 0.042, 0.09, 0.08},
            {"fitted", "45 degrees", "standing", "wrist", 0.02, 0.03, 0.04, 0.03, 0.04, 0.04},
            {"judged", "45 degrees", "standing", "head", 0.05, 0.06, 0.07, 0.042, 0.07, 0.08}};
  return s;
}

TEST(TwinsTables, SetRecordedBesideSimulatedAndJudgedBeforeFitted) {
  const std::vector<Table> tables = twins_tables(summary());
  ASSERT_EQ(tables.size(), 2u);
  EXPECT_EQ(tables[0].id, "judged");
  EXPECT_THAT(tables[0].title, testing::HasSubstr("simulated"));
  EXPECT_EQ(tables[1].rows.at(0).at(2).text, "4.0 / 4.2; 6 / 9");
  EXPECT_EQ(tables[0].rows.at(0).at(3).text, "-");
}

TEST(TwinsTables, SayInHowManyCellsBothAgree) {
  EXPECT_THAT(twins_sentences(summary()),
              testing::ElementsAre(
                  testing::AllOf(testing::HasSubstr("judged"), testing::HasSubstr("in 1 of 1 cells")),
                  testing::AllOf(testing::HasSubstr("medians agree within 25 % in 1 of 2 cells"),
                                 testing::HasSubstr("within 40 % in 1 of 2 cells"))));
  const std::vector<Figure> figures = twins_figures(summary());
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_NEAR(figures[0].series[0].points[1].x, 2.0, 1e-12);
}

}  // namespace
}  // namespace trilat
