// SPDX-License-Identifier: MIT
// The tables of an accuracy study, each row against chosen numbers.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/shown/accuracy_words.h"
#include "tests/pipeline/chosen_summary.h"
#include "tests/pipeline/table_rows.h"

namespace trilat {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

TEST(AccuracyTables, MethodsByJointMarkTheBestAndCountAnswersWhereSomeAreMissing) {
  ResultsSummary s = summary_of({"linear", "mean", "rts"}, {"head", "wrist"});
  for (const char* group : {"head", "wrist", "average"}) {
    add_error(s, "linear", group, 5.0);
    add_error(s, "mean", group, 4.0);
    add_error(s, "rts", group, 4.2);
  }
  s.best = {{"walking", "head", "mean", {"rts"}}, {"walking", "average", "mean", {}}};
  Table table = article_tables(s).at(0);
  EXPECT_EQ(table.id, "errors-walking");
  EXPECT_EQ(table.printed, "table3");
  EXPECT_THAT(rows_of(table), ElementsAre("mean | 4.0 (3.6 to 4.4)* | 4.0 (3.6 to 4.4) | 4.0 (3.6 to 4.4)*",
                                          "rts | 4.2 (3.8 to 4.6)~ | 4.2 (3.8 to 4.6) | 4.2 (3.8 to 4.6)",
                                          "linear | 5.0 (4.5 to 5.5) | 5.0 (4.5 to 5.5) | 5.0 (4.5 to 5.5)"));
  EXPECT_EQ(table.about, "lab, walking, simulated sensors; alignment: mean; 3 of 4 takes, 3 participants");
  // another method that answers not all, and other truths, alignments and movements than the paper's
  s.methods.push_back("window");
  add_error(s, "window", "average", 6.0, 99);
  add_error(s, "window", "head", 6.0, 99);
  table = article_tables(s).at(0);
  EXPECT_EQ(table.columns.back().key, "answered_percent");
  EXPECT_THAT(rows_of(table).back(), testing::EndsWith(" | - | 6.0 (5.4 to 6.6) | 99.0"));
  s.truth = kLeftOutTruth;
  EXPECT_EQ(article_tables(s).at(0).printed, "");
  s.truth = kMocapTruth;
  EXPECT_TRUE(is_like_the_papers(s, "walking"));
  EXPECT_FALSE(is_like_the_papers(s, "arm_swing"));
  s.alignments = {"none"};
  EXPECT_FALSE(is_like_the_papers(s, "walking"));
  EXPECT_THAT(article_tables(s), IsEmpty());  // no number of it
}

TEST(AccuracyTables, EveryStatisticStandsInItsColumn) {
  ResultsSummary s = summary_of({"linear"}, {"head"});
  add_error(s, "linear", "head", 5.0, 80);
  const NumberKey key{.condition = "walking", .group = "head", .method = "linear", .alignment = "mean"};
  const auto add = [&](const char* measure, const char* statistic, double value, std::uint64_t n = 80) {
    s.numbers.add({key.with({.measure = measure, .statistic = statistic}), value, kNaN, kNaN, n});
  };
  double m = 0.06;
  for (const char* statistic : {"rms", "median", "p90", "p95", "max"}) {
    add("distance", statistic, m);
    m += 0.01;
  }
  for (const char* axis : {"x", "y", "z"}) {
    add(axis, "mean_abs", m);
    m += 0.01;
  }
  add("iterations", "mean", 2.5);
  add("status", "converged", 0.8);
  add("status", "too_few_ranges", 0.2, 20);
  const std::vector<Table> tables = accuracy_tables(s);
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(tables[0].id, "accuracy-walking-mean");
  EXPECT_THAT(
      rows_of(tables[0]),
      ElementsAre("head | linear | 80 | 80.0 | 5.00 (4.50 to 5.50) | 6.00 | 7.00 | 8.00 | 9.00 | 10.00 | "
                  "11.00 | 12.00 | 13.00 | 2.5 | converged 80.0 %, too_few_ranges 20.0 %"));
  EXPECT_THAT(all_text(tables[0].notes), Not(HasSubstr("Answered less")));  // 80 % are enough
}

TEST(AccuracyTables, SilentMethodsAreNamedWithWhatMostOftenEndsThem) {
  ResultsSummary s = summary_of({"linear", "mean", "rts"}, {"head", "wrist"});
  for (const char* group : {"head", "wrist", "average"}) {
    add_error(s, "linear", group, 5.0, 79);
    add_error(s, "mean", group, 5.0, 80);
    add_error(s, "rts", group, 5.0, 0);
  }
  const NumberKey key{.condition = "walking", .group = "average", .method = "linear", .alignment = "mean"};
  const auto add = [&](const char* method, const char* status, double share) {
    s.numbers.add(
        {key.with({.method = method, .measure = "status", .statistic = status}), share, kNaN, kNaN, 79});
  };
  add("linear", "converged", 0.79);
  add("linear", "too_few_ranges", 0.06);
  add("linear", "rank_deficient", 0.15);
  Table table = accuracy_tables(s).at(0);
  EXPECT_THAT(all_text(table.notes), Not(HasSubstr("rts")));  // of which no status is known
  add("rts", "too_few_ranges", 1.0);
  table = accuracy_tables(s).at(0);
  EXPECT_THAT(
      table.notes,
      Contains("Answered less than 80 %, so that errors by themselves flatter these methods: linear 79 % "
               "(rank_deficient 15 %), rts 0 % (too_few_ranges 100 %). Compare them by the "
               "differences, which are of samples that both answer."));
  const std::string warnings = all_text(accuracy_warnings(s));
  EXPECT_THAT(warnings, HasSubstr("`linear` answers only 79 % in walking: its error is of these alone."));
  EXPECT_THAT(warnings, HasSubstr("`rts` answers nothing in walking."));
  EXPECT_THAT(warnings, Not(HasSubstr("`mean`")));
}

TEST(AccuracyTables, DifferencesAreJudgedByTheirIntervals) {
  ResultsSummary s = summary_of({"linear", "better", "worse", "same", "short", "silent"}, {"head"});
  for (const std::string& method : s.methods)
    add_error(s, method, "head", 5.0, method == "silent" ? 79 : 100);
  add_difference(s, "better", "head", -2.0, -3.0, -1.0);
  add_difference(s, "worse", "head", 2.0, 1.0, 3.0);
  add_difference(s, "same", "head", 0.5, -1.0, 2.0);
  add_difference(s, "short", "head", 0.5, kNaN, kNaN);
  add_difference(s, "silent", "head", 2.0, 1.0, 3.0);
  const Table table = differences_table(s, "walking", "mean");
  EXPECT_EQ(table.id, "differences-walking-mean");
  EXPECT_EQ(table.title, "Mean absolute error, method less \"linear\", over the samples that both answered");
  EXPECT_THAT(
      rows_of(table),
      ElementsAre("head | better | 90 | -2.00 (-3.00 to -1.00) | -20.0 (-30.0 to -10.0) | -25.0 | better+",
                  "head | worse | 90 | 2.00 (1.00 to 3.00) | 20.0 (10.0 to 30.0) | 16.7 | worse-",
                  "head | same | 90 | 0.50 (-1.00 to 2.00) | 5.0 (-10.0 to 20.0) | 4.8 | no",
                  "head | short | 90 | 0.50 | 5.0 | 4.8 | –",
                  "head | silent | 90 | 2.00 (1.00 to 3.00) | 20.0 (10.0 to 30.0) | 16.7 | worse, where it "
                  "answers (79 %)"));
  EXPECT_EQ(difference_text(s, "walking", "mean", "better"), "20 % (10 to 30) less than `linear`");
  EXPECT_EQ(difference_text(s, "walking", "mean", "worse"), "20 % (10 to 30) more than `linear`");
  EXPECT_EQ(difference_text(s, "walking", "mean", "same"), "not to be distinguished from `linear`");
  EXPECT_EQ(difference_text(s, "walking", "mean", "short"), "");
  EXPECT_EQ(difference_text(s, "walking", "mean", "linear"), "");
}

TEST(AccuracyTables, BodiesAndAgreementHaveARowAMethodAndAxis) {
  ResultsSummary s = summary_of({"linear", "mean"}, {"head", "wrist"});
  s.alignments = {"mean", "none"};
  EXPECT_EQ(body_alignment(s), "none");
  add_error(s, "linear", "head", 5.0);
  const NumberKey body{.condition = "walking", .method = "mean"};
  const auto add = [&](const NumberKey& more, double value, std::uint64_t n) {
    s.numbers.add({body.with(more), value, kNaN, kNaN, n});
  };
  add({.alignment = "none", .measure = "mpjpe", .statistic = "mean"}, 0.07, 30);
  add({.measure = "pa_mpjpe", .statistic = "mean"}, 0.05, 30);
  double share = 0.2;
  for (const char* radius : {"5_cm", "10_cm", "15_cm"}) {
    add({.alignment = "none", .measure = "within", .statistic = radius}, share, 30);
    share += 0.25;
  }
  add({.measure = "bone", .statistic = "sd"}, 0.012, 8);
  add({.measure = "jerk", .statistic = "mean"}, 123.4, 30);
  s.numbers.add({{.condition = "walking", .measure = "jerk", .statistic = "mean_of_truth"}, 40.0});
  const Table bodies = bodies_table(s, "walking");
  EXPECT_THAT(rows_of(bodies), ElementsAre("mean | 30 | 7.00 | 5.00 | 20.0 | 45.0 | 70.0 | 1.20 | 123"));
  EXPECT_THAT(all_text(bodies.notes), HasSubstr("that of the truth is 40 m/s³"));
  EXPECT_THAT(all_text(bodies.notes), HasSubstr("8 bones"));
  s.alignments = {"mean"};
  EXPECT_EQ(body_alignment(s), "mean");
  EXPECT_THAT(bodies_table(s, "walking").rows, IsEmpty());

  const NumberKey axis{.condition = "walking", .group = "head", .method = "linear", .alignment = "mean"};
  for (const auto& [name, m] : {std::pair{"x", 0.01}, {"y", 0.02}, {"z", -0.03}})
    for (const auto& [statistic, times] :
         {std::pair{"bias", 1.0}, {"lower_limit", -2.0}, {"upper_limit", 3.0}, {"sd", 4.0}})
      s.numbers.add({axis.with({.measure = name, .statistic = statistic}), times * m, kNaN, kNaN, 10});
  const Table agreement = agreement_table(s, "walking", "mean");
  EXPECT_EQ(agreement.rows.size(), 6u);  // two methods, three axes, and no average
  EXPECT_EQ(rows_of(agreement)[0], "linear | head | x | 1.0 | -2.0 | 3.0 | 4.0");
  EXPECT_EQ(rows_of(agreement)[2], "linear | head | z | -3.0 | 6.0 | -9.0 | -12.0");
  s.alignments = {"mean", "rigid", "none"};
  EXPECT_EQ(agreement_tables(s).size(), 2u);
}

TEST(AccuracyTables, Table2StandsBesideOursWhereTheJointsAreThePapers) {
  ResultsSummary s =
      summary_of({"nonlinear", "nonlinear, occlusion corrected", "mean"}, {"shoulder", "wrist"});
  s.conditions = {"arm_swing", occluded_condition("arm_swing"), "leg_crossing"};
  EXPECT_THAT(table2(s), IsEmpty());
  for (const std::string& condition : s.conditions)
    for (const std::string& method : s.methods)
      for (const char* group : {"shoulder", "average"}) add_error(s, method, group, 5.0, 100, condition);
  const auto rows = [&] { return rows_of(table2(s).at(0)); };
  EXPECT_THAT(
      rows(),
      ElementsAre("arms | occluded | nonlinear | 18.5 | 5.00 (4.50 to 5.50) | 100 | 100.0",
                  "arms | occluded | nonlinear, occlusion corrected | 13.3 | 5.00 (4.50 to 5.50) | 100 | "
                  "100.0",
                  "arms | occluded | mean | - | 5.00 (4.50 to 5.50) | 100 | 100.0",
                  "arms | all | nonlinear | - | 5.00 (4.50 to 5.50) | 100 | 100.0",
                  "arms | all | nonlinear, occlusion corrected | - | 5.00 (4.50 to 5.50) | 100 | 100.0",
                  "arms | all | mean | - | 5.00 (4.50 to 5.50) | 100 | 100.0",
                  "legs | all | nonlinear | - | 5.00 (4.50 to 5.50) | 100 | 100.0",
                  "legs | all | nonlinear, occlusion corrected | - | 5.00 (4.50 to 5.50) | 100 | 100.0",
                  "legs | all | mean | - | 5.00 (4.50 to 5.50) | 100 | 100.0"));
  EXPECT_EQ(table2(s)[0].columns[4].name, "ours, simulated (cm)");
  EXPECT_EQ(table2(s)[0].about, "simulated sensors, 3 of 4 takes, 3 participants; alignment: mean");
  // a joint that is none of the paper's arms
  s.groups.push_back("head");
  add_error(s, "mean", "head", 5.0, 100, occluded_condition("arm_swing"));
  EXPECT_THAT(rows()[0], HasSubstr("| nonlinear | - |"));
  s.numbers = {};
  add_error(s, "mean", "average", 5.0, 0, "arm_swing");
  EXPECT_THAT(rows(), ElementsAre("arms | all | mean | - | - | 0 | 0.0"));
  s.truth = kLeftOutTruth;
  EXPECT_THAT(table2(s), IsEmpty());
}

TakeJointRow joint_row(const char* take, const char* joint, const char* method, double cm,
                       std::uint64_t answered) {
  return {take, std::string("p") + take, "walking", joint, joint, method, 100, answered, 0.01 * cm};
}

TEST(AccuracyTables, TakesStandByTheBestMethodsErrorAndJointsEachApart) {
  ResultsSummary s = summary_of({"mean", "linear"}, {"head"});
  add_error(s, "mean", "head", 5.0);
  add_error(s, "linear", "head", 6.0);
  add_row(joint_row("1", "head", "mean", 2.0, 100), s);
  EXPECT_THAT(takes_tables(s), IsEmpty());  // of one take
  add_row(joint_row("1", "head", "linear", 9.0, 100), s);
  add_row(joint_row("2", "head", "mean", 4.0, 50), s);
  add_row(joint_row("2", "wrist", "mean", 7.0, 100), s);
  add_row(joint_row("2", "head", "linear", 1.0, 100), s);
  add_row(joint_row("3", "head", "mean", kNaN, 0), s);
  s.best = {{"walking", "head", "mean", {}}};
  Table table = takes_tables(s).at(0);
  EXPECT_EQ(table.id, "takes-walking");
  EXPECT_THAT(rows_of(table), ElementsAre("3 | p3 | - | - | 0.0", "2 | p2 | 6.00 | 1.00 | 75.0",
                                          "1 | p1 | 2.00 | 9.00 | 100.0"));
  s.best[0].method = "linear";
  EXPECT_THAT(
      rows_of(takes_tables(s).at(0)),
      ElementsAre("3 | p3 | - | - | -", "1 | p1 | 2.00 | 9.00 | 100.0", "2 | p2 | 6.00 | 1.00 | 100.0"));
  EXPECT_EQ(table.first_rows, 3u);
  for (int t = 4; t < 13; ++t) add_row(joint_row(std::to_string(t).c_str(), "head", "mean", 2.0, 100), s);
  EXPECT_EQ(takes_tables(s).at(0).first_rows, 10u);
  table = joint_tables_by_take(s).at(0);
  EXPECT_EQ(rows_of(table)[2], "2 | p2 | walking | head | mean | 100 | 50 | 50.0 | 4.00");
}

TEST(AccuracyTables, FilesAreHeldAgainstTheTruthByAlignment) {
  ResultsSummary s = summary_of({"a", "b", "c"}, {"head", "wrist"});
  add_error(s, "a", "head", 6.0, 50);
  add_error(s, "a", "wrist", 2.0);
  add_error(s, "a", "average", 4.0);
  add_error(s, "b", "head", 3.0);
  add_error(s, "c", "head", 3.0, 0);
  const NumberKey key{.condition = "walking", .group = "head", .method = "a", .alignment = "mean"};
  for (const auto& [axis, m] : {std::pair{"x", 0.01}, {"y", -0.02}, {"z", 0.04}})
    for (const char* group : {"head", "wrist"})
      s.numbers.add({key.with({.group = group, .measure = axis, .statistic = "bias"}),
                     group[0] == 'h' ? m : 0.0, kNaN, kNaN, 50});
  add_row(joint_row("1", "neck", "a", 2.0, 100), s);
  add_row(joint_row("1", "hand", "a", 2.0, 0), s);
  const Table table = files_table(s, "walking");
  EXPECT_EQ(table.columns.back().name, "joints of 2");
  EXPECT_THAT(rows_of(table), ElementsAre("mean | b | 3.00 | 100.0 | - | - | - | 0",
                                          "mean | a | 4.00 (3.60 to 4.40) | 75.0 | 0.50 | -1.00 | 2.00 | 1",
                                          "mean | c | - | 0.0 | - | - | - | 0"));
}

TEST(AccuracyTables, AnglesAreInDegreesAndTheirFigureHasADotATake) {
  ResultsSummary s = summary_of({"linear", "mean"}, {"head"});
  EXPECT_THAT(angle_tables(s), IsEmpty());
  add_error(s, "linear", "head", 5.0);
  add_error(s, "mean", "head", 4.0);
  const double degree = 1.0 / kDegreesPerRad;
  const NumberKey key{.condition = "walking", .group = "knee", .method = "linear", .measure = "angle"};
  double value = 1.0;
  for (const char* statistic :
       {"mean_abs", "rms", "bias", "lower_limit", "upper_limit", "motion_range", "true_motion_range"}) {
    s.numbers.add({key.with({.statistic = statistic}), value * degree, kNaN, kNaN, 40});
    value += 1.0;
  }
  const auto add_take = [&](const char* take, const char* method, double bias, double truth) {
    const NumberKey of{.method = method, .take = take};
    s.numbers.add({key.with(of).with({.statistic = "bias"}), bias * degree, kNaN, kNaN, 40});
    s.numbers.add({key.with(of).with({.statistic = "mean_of_truth"}), truth * degree, kNaN, kNaN, 40});
  };
  add_take("1", "linear", 4.0, 20.0);
  add_take("2", "linear", -2.0, 50.0);
  add_take("1", "mean", 6.0, 20.0);
  const Table table = angle_tables(s).at(0);
  EXPECT_EQ(table.id, "angles-walking");
  EXPECT_THAT(rows_of(table), ElementsAre("knee | linear | 1.0 | 2.0 | 3.0 | 4.0 | 5.0 | 6.0 | 7.0 | 40"));
  EXPECT_THAT(all_text(table.notes), HasSubstr("repeated are those of participants"));
  const Figure figure = angle_figures(s).at(0);
  EXPECT_THAT(figure.panels, ElementsAre("knee"));
  ASSERT_EQ(figure.series.size(), 5u);  // two methods, a bias and two limits
  ASSERT_EQ(figure.series[0].points.size(), 2u);
  EXPECT_NEAR(figure.series[0].points[0].x, 22.0, 1e-9);
  EXPECT_NEAR(figure.series[0].points[0].y, 4.0, 1e-9);
  EXPECT_NEAR(figure.series[0].points[1].x, 49.0, 1e-9);
  ASSERT_EQ(figure.series[1].points.size(), 1u);
  EXPECT_NEAR(figure.series[1].points[0].x, 23.0, 1e-9);
  for (std::size_t line = 2; line < 5; ++line) {
    EXPECT_NEAR(figure.series[line].points[0].x, 22.0, 1e-9);
    EXPECT_NEAR(figure.series[line].points[1].x, 49.0, 1e-9);
    EXPECT_NEAR(figure.series[line].points[0].y, 1.0 + static_cast<double>(line), 1e-9);
    EXPECT_NEAR(figure.series[line].points[1].y, 1.0 + static_cast<double>(line), 1e-9);
  }
}

TEST(AccuracyTables, TheBoundStandsBesideTheMethodsOfRanges) {
  ResultsSummary s = summary_of(
      {"linear", "nonlinear", "nonlinear, occlusion corrected", "nonlinear, k1 left out", "mean", "median"},
      {"head"});
  s.alignments = {"mean", "none"};
  TrackingSummary tracking{.study = "table3", .simulated = true};
  EXPECT_THAT(bound_tables(s, tracking), IsEmpty());
  // 4 ranges that err by 2 cm each, and a geometry of 1.5
  tracking.bounds = {{"walking", "head", 2, 4, 4 * 0.0004, 3.0}};
  const NumberKey key{.condition = "walking", .group = "head", .method = "linear", .alignment = "none"};
  s.numbers.add({key.with({.measure = "distance", .statistic = "mean"}), 0.06});
  Table table = bound_tables(s, tracking).at(0);
  std::vector<std::string> names;
  for (const TableColumn& column : table.columns) names.push_back(column.name);
  EXPECT_THAT(names, ElementsAre("condition", "joint", "n", "ranges err by (cm)", "GDOP", "bound (cm)",
                                 "linear (cm)", "linear / bound", "nonlinear (cm)", "nonlinear / bound",
                                 "nonlinear, k1 left out (cm)", "nonlinear, k1 left out / bound", "mean (cm)",
                                 "mean / bound"));
  EXPECT_THAT(rows_of(table),
              ElementsAre("walking | head | 2 | 2.00 | 1.50 | 3.00 | 6.00 | 2.00 | - | - | - | - | - | -"));
  EXPECT_THAT(table.title, HasSubstr("(table3, simulated sensors; alignment: none)"));
  s.alignments = {"mean"};
  EXPECT_THAT(bound_tables(s, tracking).at(0).title, HasSubstr("alignment: mean"));
  s.truth = kLeftOutTruth;
  EXPECT_THAT(bound_tables(s, tracking), IsEmpty());
}

TEST(AccuracyTables, WhatIsKnownOfTheSensorsHasATableOfItsOwn) {
  TrackingSummary s{.study = "mine"};
  EXPECT_THAT(tracking_tables(s), IsEmpty());
  s.clocks = {{"1", "found", 0.05, 0.04, 0.06, 12.0, 3.0, 0.9, 0.4, true}, {"2", "too_little_motion"}};
  s.rays = {
      {.take = "1", .range_m = 0.02, .bearing_m = 0.01, .ratio = 2.0, .ratio_low = 1.5, .ratio_high = 2.5},
      {.take = "2", .problem = "too few sensors"}};
  s.rules = {{"walking", "printed", "wrist", 200, 50, 40, 10}, {"walking", "printed", "head", 200, 0, 0, 0}};
  const std::vector<Table> tables = tracking_tables(s);
  ASSERT_EQ(tables.size(), 3u);
  EXPECT_EQ(tables[0].about, "mine, recorded sensors");
  EXPECT_THAT(rows_of(tables[0]),
              ElementsAre("1 | 50.00 (40.00 to 60.00) | 12 | 3 | 0.900 | 0.400 | found | yes",
                          "2 | - | - | - | - | - | too_little_motion | no"));
  EXPECT_THAT(rows_of(tables[1]),
              ElementsAre("1 | 2.00 | 1.00 | 2.00 (1.50 to 2.50) | ", "2 | - | - | - | too few sensors"));
  EXPECT_THAT(rows_of(tables[2]), ElementsAre("walking | wrist | printed | 200 | 25.0 | 20.0 | 25.0 | 20.0",
                                              "walking | head | printed | 200 | 0.0 | 0.0 | - | -"));
  EXPECT_EQ(ray_text(s.rays[0]),
            "sensors disagree by 2.0 cm along their rays and 1.0 cm across, ratio 2.00 (1.50 to 2.50)");
  EXPECT_EQ(ray_text(s.rays[1]), "along/across the rays: not known, too few sensors");
  const auto row = [](const char* sensor, const char* what, const char* unit, double value) {
    return CheckRow{.subject = sensor, .what = what, .unit = unit, .value = value, .low = 0.0, .high = value};
  };
  EXPECT_THAT(
      pose_lines({row("k1", "turned", "rad", 0.1), row("k1", "shifted", "m", 0.02),
                  row("k1", "other", "m", 1.0), row("k2", "ranges too long", "m", 0.03)}),
      ElementsAre("k1, beside its calibration: turned by 5.7 (0.0 to 5.7) degrees, shifted by 2.0 (0.0 to "
                  "2.0) cm",
                  "k2, beside its calibration: ranges too long by 3.0 (0.0 to 3.0) cm"));
}

TEST(AccuracyTables, PredictionsOfALeftOutSensorHaveARowAMethod) {
  ResultsSummary s = summary_of({"linear", "mean"}, {"head"});
  EXPECT_THAT(prediction_tables(s), IsEmpty());
  const NumberKey key{.condition = "walking", .method = "mean"};
  double m = 0.01;
  for (const auto& [measure, statistic] :
       {std::pair{"range", "mean_abs"}, {"bearing", "mean"}, {"range", "bias"}, {"bone", "sd"}}) {
    s.numbers.add({key.with({.measure = measure, .statistic = statistic}), m, kNaN, kNaN, 70});
    m += 0.01;
  }
  s.numbers.add({key.with({.measure = "jerk", .statistic = "mean"}), 55.0, kNaN, kNaN, 60});
  EXPECT_THAT(rows_of(prediction_tables(s).at(0)),
              ElementsAre("walking | mean | 1.00 | 2.00 | 3.00 | 4.00 | 55 | 70"));
}

}  // namespace
}  // namespace trilat
