// SPDX-License-Identifier: MIT
// Stages, warnings, findings and figures of an accuracy study, against chosen numbers.
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

// Three participants at two stages; the reference's joints err by 1, 2 and 3 cm more at the second.
ResultsSummary staged() {
  ResultsSummary s = summary_of({"mean", "linear"}, {"head"});
  s.conditions = {"walking, exact", "walking, live"};
  for (const char* method : {"mean", "linear"}) {
    add_error(s, method, "head", 4.0, 100, "walking, exact");
    add_error(s, method, "head", 6.0, 90, "walking, live");
  }
  for (int p = 1; p <= 3; ++p)
    for (const char* method : {"mean", "linear"})
      for (const char* condition : {"walking, exact", "walking, live"}) {
        const bool live = std::string(condition).ends_with("live"), is_mean = method[0] == 'm';
        add_row({fmt::format("{}.{}", p, live ? 2 : 1), std::to_string(p), condition, "head", "head", method,
                 100, 100, 0.04 + (live && is_mean ? 0.01 * p : 0.0)},
                s);
      }
  return s;
}

TEST(AccuracyFindings, StagesChangeWhatTheOnesBeforeLeft) {
  const ResultsSummary s = staged();
  const std::vector<Table> tables = stages_tables(s, {"exact", "live"});
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(tables[0].id, "stages-walking");
  // 2 cm on average; t of 2 degrees of freedom times 1 / sqrt(3)
  EXPECT_THAT(rows_of(tables[0]),
              ElementsAre("mean | exact | - | 4.0 (3.6 to 4.4) | 100.0",
                          "mean | live | 2.00 (-0.48 to 4.48) | 6.0 (5.4 to 6.6) | 90.0",
                          "linear | exact | - | 4.0 (3.6 to 4.4) | 100.0",
                          "linear | live | 0.00 (0.00 to 0.00) | 6.0 (5.4 to 6.6) | 90.0"));
  EXPECT_THAT(
      stages_findings(s, {"exact", "live"}),
      ElementsAre("**Simulated, walking**: `mean` errs by 4.0 cm (exact), 6.0 cm (live), each stage with "
                  "those before it. The largest step is \"live\": +2.0 cm (-0.5 to 4.5)."));
  const Figure figure = stages_figures(s, {"exact", "live"}).at(0);
  EXPECT_EQ(figure.id, "stages-walking");
  EXPECT_THAT(figure.y_names, ElementsAre("exact", "live"));
  ASSERT_EQ(figure.series.size(), 2u);
  EXPECT_NEAR(figure.series[0].points[1].x, 6.0, 1e-9);
  EXPECT_NEAR(figure.series[0].points[1].low, 5.4, 1e-9);
  EXPECT_NEAR(figure.series[0].points[1].high, 6.6, 1e-9);
  EXPECT_EQ(figure.series[0].points[1].y, 1.0);
  EXPECT_TRUE(figure.is_first);
  EXPECT_THAT(stages_tables(s, {"act", "live"}), IsEmpty());  // "act" only ends the name "exact"
}

TEST(AccuracyFindings, OfStagesOnlyTheFirstsNotesAndAllFailuresWarn) {
  ResultsSummary s = staged();
  s.notes = {{"1.1", false, "k1", "first"},
             {"1.2", false, "k1", "second"},
             {"2.2", true, "k2", "failed"},
             {"", false, "study", "all"}};
  EXPECT_THAT(stages_warnings(s, {"exact", "live"}),
              ElementsAre("Take 2.2 failed: k2: failed.",
                          "The checks noted 2 things, the first: take 1.1: k1: "
                          "first.",
                          "Only 3 participants: intervals are wide, and hold for people like these alone."));
}

TEST(AccuracyFindings, WarningsSayWhatCeresContradictsAndWhoWasMeasured) {
  ResultsSummary s = summary_of({"mean"}, {"head"});
  add_error(s, "mean", "head", 4.0);
  s.participants = 6;
  EXPECT_THAT(accuracy_warnings(s), IsEmpty());
  s.participants = 2;
  EXPECT_THAT(accuracy_warnings(s),
              ElementsAre(HasSubstr("Only 2 participants: intervals are between takes")));
  EXPECT_THAT(interval_note(s), HasSubstr("takes or, of a single take"));
  s.participants = 3;
  EXPECT_THAT(interval_note(s), HasSubstr("between participants."));
  s.participants = 1;
  EXPECT_THAT(accuracy_warnings(s), ElementsAre(HasSubstr("Only 1 participant: ")));
  s.participants = 6;
  s.notes = {{"t", true, "a.h5", "is no session"}, {"t", false, "k1", "is it mirrored?"}};
  EXPECT_THAT(accuracy_warnings(s),
              ElementsAre("Take t failed: a.h5: is no session.",
                          "The checks noted 1 thing, namely: take t: k1: is it mirrored?"));
  EXPECT_THAT(accuracy_warnings(s, false), IsEmpty());
  s.cross_checks = {{.method = "none", .worst_at = ""},
                    {.method = "good", .samples = 5, .worst_m = 1e-9, .limit_m = 1e-6, .worst_at = ""},
                    {.method = "bad", .samples = 5, .worst_m = 0.25, .limit_m = 1e-6, .worst_at = ""}};
  EXPECT_THAT(accuracy_warnings(s, false),
              ElementsAre("`none` was not compared with Ceres: no sample has an answer of both.",
                          "`bad` disagrees with Ceres by up to 0.25 m."));
  const std::vector<std::string> notes = accuracy_shown(s, {}).tables.at(0).notes;
  EXPECT_THAT(notes,
              Contains("Cross-check of good with Ceres, agrees: 5 problems, largest distance 1e-09 m (limit "
                       "1e-06 m), 0 answered by one only, 0 objectives lost."));
  EXPECT_THAT(notes, Contains(HasSubstr("Cross-check of bad with Ceres, DISAGREES: 5 problems")));
  EXPECT_THAT(notes, Contains("Take t failed: a.h5: is no session."));
}

TEST(AccuracyFindings, FindingsNameTheBestItsShareAndTheReference) {
  ResultsSummary s = summary_of({"linear", "mean"}, {"head"});
  add_error(s, "linear", "head", 5.0);
  add_error(s, "mean", "head", 4.0, 90);
  add_difference(s, "mean", "head", -2.0, -3.0, -1.0);
  s.best = {{"walking", "head", "mean", {}}};
  EXPECT_THAT(
      accuracy_findings(s),
      ElementsAre(
          "**walking**, simulated: `mean` has the smallest error of 2 methods, 4.0 cm (3.6 to 4.4) on "
          "the 90.0 % that it answers, 20 % (10 to 30) less than `linear`."));
  s.best[0].not_distinguished = {"linear"};
  s.participants = 5;
  EXPECT_THAT(accuracy_findings(s).front(), Not(HasSubstr("less than")));
  EXPECT_THAT(accuracy_findings(s).front(),
              HasSubstr("; 1 other cannot be distinguished from it (`linear`)."));
  s.participants = 1;
  EXPECT_THAT(accuracy_findings(s).front(), HasSubstr("; 1 participant is too few to rule out 1 other, the"));
  s.best[0].not_distinguished = {"a", "b", "c", "d"};
  EXPECT_THAT(accuracy_findings(s).front(), HasSubstr("(`a`, `b`, `c`, `d`)"));
  s.best[0].not_distinguished.push_back("e");
  EXPECT_THAT(accuracy_findings(s).front(), HasSubstr("(among them `a`, `b`, `c`, `d`)"));
  s.methods = {"mean"};
  s.simulated = false;
  s.truth = kLeftOutTruth;
  EXPECT_THAT(
      accuracy_findings(s).front(),
      HasSubstr("**walking**, recorded: `mean` has a mean difference from the sensor left out of 4.0 cm"));
  EXPECT_THAT(truth_note(s), HasSubstr("There is no ground truth"));
  EXPECT_EQ(about(s, "", ""),
            "lab, recorded sensors; against the sensor left out; 3 of 4 takes, 1 participant");
}

TEST(AccuracyFindings, TheBestSingleSensorIsAmongTheFirstMethods) {
  ResultsSummary s =
      summary_of({"linear", "a", "b", "c", "d", "e", "f", "single k1", "single k2", "singleton"}, {"head"});
  for (const std::string& method : s.methods) add_error(s, method, "head", 5.0);
  s.numbers = {};
  for (const std::string& method : s.methods)
    add_error(s, method, "head", method == "single k2" ? 4.0 : method == "singleton" ? 1.0 : 6.0);
  EXPECT_THAT(leading_methods(s, "walking"), Contains("single k2"));
  EXPECT_THAT(leading_methods(s, "walking"), Not(Contains("single k1")));
}

TEST(AccuracyFigures, JointsGoFromHeadToFootAndSensorsAreCounted) {
  ResultsSummary s = summary_of({"linear"}, {"ankle", "thumb", "head", "knee", "wrist", "elbow", "hip"});
  for (const std::string& group : s.groups) add_error(s, "linear", group, 5.0);
  add_error(s, "linear", "average", 6.0);
  s.families = {
      {"linear, 3 sensors", 3, {"a", "b"}}, {"linear, 4 sensors", 4, {"c", "d"}}, {"odd", 2, {"e", "f"}}};
  for (const auto& [name, cm] :
       {std::pair{"linear, 3 sensors", 7.0}, {"linear, 4 sensors", 6.0}, {"odd", 5.0}})
    s.numbers.add({{.condition = "walking",
                    .group = "average",
                    .method = name,
                    .alignment = "mean",
                    .measure = "distance",
                    .statistic = "mean_of_sets"},
                   0.01 * cm,
                   0.01 * (cm - 1.0),
                   0.01 * (cm + 1.0)});
  const std::vector<Figure> figures = accuracy_figures(s);
  ASSERT_EQ(figures.size(), 2u);
  EXPECT_THAT(figures[0].panels, ElementsAre("average", "head", "elbow", "wrist", "hip", "knee"));
  EXPECT_EQ(
      figures[0].caption,
      "Simulated walking, 3 participants: mean error with its 95 % interval, alignment mean. 6 of 8 joint "
      "groups; the tables have all.");
  EXPECT_EQ(figures[0].printed, "table3");
  EXPECT_NEAR(figures[0].series[0].points[0].x, 6.0, 1e-9);
  EXPECT_NEAR(figures[0].series[0].points[0].high, 6.6, 1e-9);
  EXPECT_EQ(figures[0].series[3].panel, 3u);
  EXPECT_EQ(figures[1].id, "sensors-walking");
  ASSERT_EQ(figures[1].series.size(), 1u);
  EXPECT_EQ(figures[1].series[0].name, "linear");
  ASSERT_EQ(figures[1].series[0].points.size(), 2u);
  EXPECT_EQ(figures[1].series[0].points[1].x, 4.0);
  EXPECT_NEAR(figures[1].series[0].points[0].y, 7.0, 1e-9);
  EXPECT_NEAR(figures[1].series[0].points[0].low, 6.0, 1e-9);
  EXPECT_TRUE(figures[1].is_first);
}

TEST(AccuracyShown, SetsOfSensorsAreLeftToTheirFigure) {
  ResultsSummary s = summary_of({"linear", "set a", "set b", "single k1", "single k2"}, {"head"});
  s.families = {{"linear, 3 sensors", 3, {"set a", "set b", "linear"}},
                {"single, 1 sensors", 1, {"single k1", "single k2"}},
                {"linear, 4 sensors", 4, {"single k2"}}};
  EXPECT_THAT(shown_summary(s).methods, ElementsAre("linear", "single k1", "single k2"));
}

}  // namespace
}  // namespace trilat
