// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "datasets/paper/printed_tables.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(PrintedCalibration, HasThePapersNumbers) {
  const PrintedCalibration paper = printed_calibration();
  EXPECT_THAT(paper.source, HasSubstr("2212.14771"));
  EXPECT_EQ(paper.samples, 100);
  EXPECT_THAT(paper.recommended_m, ElementsAre(0.8, 3.0));
  EXPECT_EQ(paper.recommended_below_deg, 26.0);
  EXPECT_EQ(paper.recommended_samples, 50);
  EXPECT_EQ(paper.recommended_mean_cm, 0.73);
  EXPECT_EQ(paper.recommended_spread_cm, 0.85);
  EXPECT_EQ(paper.near_m, 0.5);
  EXPECT_EQ(paper.near_valid_percent, 20.0);
}

TEST(PrintedCalibration, HasThePapersClaimOfDistortion) {
  const PrintedCalibration paper = printed_calibration();
  EXPECT_EQ(paper.wall_m, 2.0);
  EXPECT_EQ(paper.wall_frames, 1000);
  EXPECT_THAT(paper.worse_columns, ElementsAre(ElementsAre(0.0, 150.0), ElementsAre(350.0, 520.0)));
  EXPECT_EQ(paper.worse, "much higher");
}

}  // namespace
}  // namespace trilat
