// SPDX-License-Identifier: MIT
#include "reports/claims.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/paper/printed_tables.h"

namespace trilat {
namespace {

using testing::HasSubstr;

// A study of walking in which a method is worse than nonlinear by so much, on average and in each group.
class Walking {
 public:
  Walking() {
    summary_.study = "table3";
    summary_.simulated = true;
    summary_.conditions = {"walking"};
    summary_.reference = "nonlinear";
    add("nonlinear", 0.06, 0.0, 0.0);
  }
  Walking& add(const std::string& method, double mae_m, double low_m, double high_m) {
    summary_.methods.push_back(method);
    for (const char* group : {"head", "shoulder", "elbow", "wrist", kAverageGroup}) {
      SummaryCell cell;
      cell.method = method;
      cell.condition = "walking";
      cell.group = group;
      cell.alignment = "mean";
      cell.asked = cell.answered = 100;
      cell.mae_m = mae_m;
      cell.mae_low_m = mae_m - 0.001;
      cell.mae_high_m = mae_m + 0.001;
      summary_.cells.push_back(cell);
      DifferenceCell d;
      d.method = method;
      d.condition = "walking";
      d.group = group;
      d.alignment = "mean";
      d.n = 100;
      d.difference_m = mae_m - 0.06;
      d.low_m = low_m;
      d.high_m = high_m;
      d.percent_of_reference = 100.0 * d.difference_m / 0.06;
      d.percent_low = 100.0 * low_m / 0.06;
      d.percent_high = 100.0 * high_m / 0.06;
      d.percent_of_method = 100.0 * d.difference_m / mae_m;
      summary_.differences.push_back(d);
    }
    return *this;
  }
  SummaryCell& cell(const std::string& method, const std::string& group) {
    for (SummaryCell& c : summary_.cells)
      if (c.method == method && c.group == group) return c;
    throw std::out_of_range(method);
  }
  const ResultsSummary& summary() const { return summary_; }

 private:
  ResultsSummary summary_;
};

// The row of a claim: paper, ours, verdict, why.
std::vector<std::string> row_of(const ClaimEvidence& evidence, const std::string& id) {
  const PrintedClaims printed = printed_claims();
  const Table table = claims_table(evidence);
  EXPECT_EQ(table.rows.size(), printed.claims.size());
  for (std::size_t k = 0; k < printed.claims.size(); ++k)
    if (printed.claims[k].id == id)
      return {table.rows[k][2].text, table.rows[k][3].text, table.rows[k][4].text, table.rows[k][5].text};
  ADD_FAILURE() << id;
  return {"", "", "", ""};
}
std::string verdict(const Walking& walking, const std::string& id) {
  ClaimEvidence evidence;
  evidence.add(walking.summary());
  return row_of(evidence, id)[2];
}

TEST(Claims, HoldFailOrStayOpenByTheIntervalOfTheDifference) {
  EXPECT_EQ(verdict(Walking().add("linear", 0.08, 0.01, 0.03), "better_than_linear"), "holds");
  EXPECT_EQ(verdict(Walking().add("linear", 0.05, -0.02, -0.005), "better_than_linear"), "does not hold");
  EXPECT_EQ(verdict(Walking().add("linear", 0.061, -0.01, 0.02), "better_than_linear"), "undecided");
  EXPECT_EQ(verdict(Walking().add("linear", 0.08, kNoNumber, kNoNumber), "better_than_linear"), "undecided");
}

TEST(Claims, SayHowMuchWorseOrBetterInPercentOfTheReference) {
  ClaimEvidence evidence;
  evidence.add(Walking().add("linear", 0.08, 0.01, 0.03).summary());
  EXPECT_THAT(row_of(evidence, "better_than_linear")[1],
              HasSubstr("linear is worse by 2.00 cm (1.00 to 3.00), 33.3 %"));
  ClaimEvidence better;
  better.add(Walking().add("linear", 0.05, -0.02, -0.005).summary());
  EXPECT_THAT(row_of(better, "better_than_linear")[1],
              HasSubstr("linear is better by 1.00 cm (0.50 to 2.00)"));
}

TEST(Claims, OfASingleSensorTakeTheBestOne) {
  Walking walking;
  walking.add("single k1", 0.07, 0.005, 0.015)
      .add("single k2", 0.05, -0.015, -0.005)
      .add("mean", 0.04, -0.03, -0.01);
  ClaimEvidence evidence;
  evidence.add(walking.summary());
  const auto row = row_of(evidence, "better_than_single");
  EXPECT_THAT(row[1], HasSubstr("k2 alone 5.00 cm"));
  EXPECT_EQ(row[2], "does not hold");
}

TEST(Claims, AboutTheSameMeansWithinATenthIntervalIncluded) {
  EXPECT_EQ(verdict(Walking().add("linear", 0.061, -0.001, 0.003).add("geometric", 0.062, 0.0, 0.005),
                    "head_similar"),
            "holds");
  EXPECT_EQ(verdict(Walking().add("linear", 0.07, 0.008, 0.012).add("geometric", 0.062, 0.0, 0.005),
                    "head_similar"),
            "does not hold");
  EXPECT_EQ(verdict(Walking().add("linear", 0.066, 0.003, 0.009).add("geometric", 0.062, 0.0, 0.005),
                    "head_similar"),
            "undecided");
}

TEST(Claims, TheWristIsWorstWhenItsIntervalIsAboveTheNext) {
  Walking walking;
  EXPECT_EQ(verdict(walking, "wrist_worst"), "undecided");
  walking.cell("nonlinear", "wrist").mae_m = 0.09;
  walking.cell("nonlinear", "wrist").mae_low_m = 0.08;
  walking.cell("nonlinear", "wrist").mae_high_m = 0.1;
  EXPECT_EQ(verdict(walking, "wrist_worst"), "holds");
}

TEST(Claims, ThreeSensorsExplainGeometricWhenNonlinearLosesByThemToo) {
  EXPECT_EQ(
      verdict(Walking().add("geometric", 0.09, 0.02, 0.04).add("nonlinear, 3 sensors", 0.08, 0.015, 0.025),
              "three_sensors"),
      "holds");
  EXPECT_EQ(
      verdict(Walking().add("geometric", 0.09, 0.02, 0.04).add("nonlinear, 3 sensors", 0.061, -0.002, 0.004),
              "three_sensors"),
      "undecided");
}

TEST(Claims, GeometricAndNonlinearOnThreeSensorsDifferByWhatTheyAnswer) {
  Walking walking;
  walking.add("geometric", 0.09, 0.02, 0.04).add("nonlinear, 3 sensors", 0.08, 0.015, 0.025);
  walking.cell("geometric", kAverageGroup).statuses = {{"closed_form", 82}, {"clamped", 18}};
  walking.cell("nonlinear, 3 sensors", kAverageGroup).answered = 82;
  ClaimEvidence evidence;
  evidence.add(walking.summary());
  EXPECT_THAT(row_of(evidence, "three_sensors")[3],
              testing::AllOf(HasSubstr("same point wherever both answer"), HasSubstr("18 % of them clamped"),
                             HasSubstr("nonlinear 82 %")));
}

// Nonlinear at 6 cm: worse by a third is 8 against 6 cm, whatever either answers besides.
TEST(Claims, ComparedErrorsAreThoseOfTheSamplesThatBothAnswer) {
  Walking walking;
  walking.add("linear", 0.08, 0.01, 0.03);
  walking.cell("linear", kAverageGroup).mae_m = 0.03;  // over the half that it answers
  walking.cell("linear", kAverageGroup).answered = 50;
  ClaimEvidence evidence;
  evidence.add(walking.summary());
  EXPECT_THAT(row_of(evidence, "better_than_linear")[3],
              HasSubstr("8.00 against 6.00 cm on the 50 % of samples that linear answers"));
}

TEST(Claims, WithoutResultsCannotBeTestedOrContradictThemselves) {
  const ClaimEvidence none;
  EXPECT_FALSE(none.is_of_the_paper());
  EXPECT_EQ(row_of(none, "better_than_linear")[2], "cannot be tested here");
  EXPECT_EQ(row_of(none, "real_time")[2], "cannot be tested here");
  const auto percentages = row_of(none, "percentages");
  EXPECT_EQ(percentages[2], "contradicts itself");
  // by one convention: (10.8 - 8.7) / 10.8, (14.1 - 8.7) / 14.1; (10.8 - 8.7) / 8.7, (14.1 - 8.7) / 8.7
  EXPECT_THAT(percentages[3], HasSubstr("19.4 and 38.3 %"));
  EXPECT_THAT(percentages[3], HasSubstr("24.1 and 62.1 %"));
  EXPECT_EQ(row_of(none, "averages")[1], "10.68, 14.05, 8.60 cm from the printed rows");
}

TEST(Claims, OfSimulatedSensorsSaySo) {
  ClaimEvidence evidence;
  evidence.add(Walking().summary());
  const Table table = claims_table(evidence);
  EXPECT_THAT(table.title, HasSubstr("simulated"));
  EXPECT_THAT(table.notes.back(), HasSubstr("simulated"));
  EXPECT_THAT(claims_table({}).title, testing::Not(HasSubstr("simulated")));
}

TEST(Claims, OcclusionCompensationIsJudgedOnOccludedSamples) {
  ResultsSummary s;
  s.reference = "nonlinear";
  s.conditions = {"arm_swing", occluded_condition("arm_swing")};
  s.methods = {"nonlinear", "nonlinear, occlusion corrected"};
  for (const std::string& method : s.methods) {
    SummaryCell cell;
    cell.method = method;
    cell.condition = occluded_condition("arm_swing");
    cell.group = kAverageGroup;
    cell.alignment = "mean";
    cell.asked = 100;
    cell.answered = 80;
    cell.mae_m = 0.05;
    s.cells.push_back(cell);
  }
  DifferenceCell d;
  d.method = s.methods[1];
  d.condition = occluded_condition("arm_swing");
  d.group = kAverageGroup;
  d.alignment = "mean";
  d.difference_m = -0.01;
  d.low_m = -0.02;
  d.high_m = -0.005;
  s.differences.push_back(d);
  ClaimEvidence evidence;
  evidence.add(s);
  EXPECT_EQ(row_of(evidence, "occlusion_arms")[2], "holds");
  EXPECT_EQ(row_of(evidence, "occlusion_legs")[2], "cannot be tested here");
  s.reference = "mean";  // its differences are from another method than the one without compensation
  ClaimEvidence other;
  other.add(s);
  EXPECT_EQ(row_of(other, "occlusion_arms")[2], "cannot be tested here");
}

// A study of a rig in which eight sensors differ from four by so much.
ResultsSummary rig(const std::string& reference, double low_m, double high_m) {
  Walking walking;
  walking.add("nonlinear, 4 sensors", 0.06, 0.0, 0.0)
      .add("nonlinear, 8 sensors", 0.06 + low_m, low_m, high_m);
  ResultsSummary s = walking.summary();
  s.reference = reference;
  return s;
}

TEST(Claims, MoreSensorsFailOnOneRigWhateverTheOthersSay) {
  const char* four = "nonlinear, 4 sensors";
  const auto verdict_of = [](const std::vector<ResultsSummary>& rigs) {
    ClaimEvidence evidence;
    for (const ResultsSummary& s : rigs) evidence.add(s);
    return row_of(evidence, "more_sensors")[2];
  };
  const ResultsSummary better = rig(four, -0.02, -0.01), open = rig(four, -0.01, 0.02),
                       worse = rig(four, 0.01, 0.02);
  EXPECT_EQ(verdict_of({better, better}), "holds");
  EXPECT_EQ(verdict_of({better, open}), "undecided");
  EXPECT_EQ(verdict_of({open, better}), "undecided");
  EXPECT_EQ(verdict_of({worse, open}), "does not hold");
  EXPECT_EQ(verdict_of({open, worse, better}), "does not hold");
  EXPECT_EQ(verdict_of({rig("nonlinear", -0.02, -0.01)}), "cannot be tested here");
}

}  // namespace
}  // namespace trilat
