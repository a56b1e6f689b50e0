// SPDX-License-Identifier: MIT
// An accuracy study's first lines, tested on chosen numbers.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/shown/accuracy_words.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

// Methods with these mean errors in centimetres, each known to 0.2 cm, against the first; a difference of
// more than 0.5 cm is significant. The smallest is the best, those within 0.5 cm are like it.
ResultsSummary chosen(std::uint64_t participants, const std::vector<std::pair<std::string, double>>& methods,
                      const std::string& alignment = "mean") {
  ResultsSummary s;
  s.study = s.campaign = "chosen";
  s.simulated = true;
  s.takes = s.participants = participants;
  s.reference = methods.front().first;
  s.conditions = {"walking"};
  s.groups = {"head"};
  s.alignments = {alignment};
  const auto best = std::ranges::min_element(methods, {}, [](const auto& m) { return m.second; });
  s.best = {{"walking", "head", best->first, {}}};
  for (const auto& [name, error_cm] : methods) {
    s.methods.push_back(name);
    s.legend.push_back({name, "what " + name + " does", name == "mine"});
    const NumberKey key{.condition = "walking", .group = "head", .method = name, .alignment = alignment};
    s.numbers.add({key.with({.measure = "answered", .statistic = "share"}), 1.0, kNaN, kNaN, 1000});
    s.numbers.add({key.with({.measure = "distance", .statistic = "mean"}), 0.01 * error_cm,
                   0.01 * (error_cm - 0.2), 0.01 * (error_cm + 0.2), 1000});
    if (name != best->first && error_cm < best->second + 0.5) s.best[0].not_distinguished.push_back(name);
    if (name == s.reference) continue;
    const double difference_cm = error_cm - methods.front().second;
    for (const auto& [statistic, unit] :
         {std::pair{"difference", 0.01}, {"relative_difference", 1.0 / methods.front().second}})
      s.numbers.add({key.with({.against = s.reference, .measure = "distance", .statistic = statistic}),
                     unit * difference_cm, unit * (difference_cm - 0.5), unit * (difference_cm + 0.5), 1000});
  }
  return s;
}

TEST(FirstScreen, AnswersTheQuestionWithYesOrNoAndOneNumber) {
  const auto first = [](double mean_cm) {
    return paper_comparison(chosen(16, {{"nonlinear", 10.0}, {"mean", mean_cm}})).front();
  };
  EXPECT_EQ(first(5.0),
            "**No**: the plain mean of the same sensors errs 50 % (45 to 55) less than `nonlinear`.");
  EXPECT_EQ(first(12.0),
            "**Yes**: the plain mean of the same sensors errs 20 % (15 to 25) more than `nonlinear`.");
  EXPECT_THAT(first(10.2), StartsWith("**Undecided**"));
}

TEST(FirstScreen, SaysWhatTrilaterationReachesWhatErrsLessAndOnWhichData) {
  const std::vector<std::string> answers = paper_comparison(
      chosen(1, {{"nonlinear", 10.0}, {"linear", 11.0}, {"mean", 5.0}, {"single k1", 4.0}}, "none"));
  ASSERT_EQ(answers.size(), 4u);
  EXPECT_EQ(answers[1],
            "Errors of trilateration: `nonlinear` 10.0 cm (9.8 to 10.2), `linear` 11.0 cm (10.8 to 11.2).");
  EXPECT_EQ(answers[2], "Methods that err less: `mean` 5.0 cm (4.8 to 5.2).");
  EXPECT_EQ(answers[3], "Data: 1 **simulated** walker, average of 1 joint group.");
  EXPECT_THAT(paper_comparison(chosen(3, {{"median", 5.0}, {"mean", 5.0}})), IsEmpty());
}

TEST(FirstScreen, FewParticipantsRuleNothingOut) {
  const auto finding = [](std::uint64_t participants) {
    return accuracy_findings(
               chosen(participants, {{"mean", 5.0}, {"rts", 4.0}, {"window", 4.1}, {"median", 4.2}}))
        .front();
  };
  EXPECT_THAT(
      finding(3),
      HasSubstr("3 participants are too few to rule out 2 others, the nearest first (`window`, `median`)"));
  EXPECT_THAT(finding(5), HasSubstr("2 others cannot be distinguished from it (`window`, `median`)"));
}

TEST(FirstScreen, WhatWasBroughtIsInTheSentenceTheFirstRowsAndTheLegend) {
  std::vector<std::pair<std::string, double>> methods{{"nonlinear", 9.0}};
  for (int m = 0; m < 12; ++m) methods.emplace_back("method " + std::to_string(m), 4.0 + m);
  methods.emplace_back("mine", 30.0);
  const ResultsSummary s = chosen(6, methods);
  EXPECT_THAT(leading_methods(s, "walking"), Contains("mine"));
  EXPECT_THAT(accuracy_findings(s).front(),
              HasSubstr("From files: `mine` 30.0 cm (29.8 to 30.2), 14 of 14."));
  EXPECT_THAT(method_legend(s), Contains("`mine`: what mine does"));
  EXPECT_THAT(accuracy_figures(s).front().y_names, Contains("mine"));
  EXPECT_THAT(accuracy_findings(chosen(6, {{"mean", 5.0}, {"mine", 3.0}})).front(),
              Not(HasSubstr("From files")));
}

TEST(FirstScreen, MethodsThatAnswerAlikeShareARow) {
  const ResultsSummary s = shown_summary(
      chosen(6, {{"mean", 5.0}, {"median", 5.0}, {"nonlinear", 5.0}, {"rts", 4.0}, {"kalman", 4.0}}));
  EXPECT_THAT(s.methods, ElementsAre("mean", "nonlinear", "rts"));
  EXPECT_EQ(row_name(s, "mean"), "mean = median");
  EXPECT_EQ(s.best[0].method, "rts");
  EXPECT_THAT(s.best[0].not_distinguished, IsEmpty());
  EXPECT_EQ(accuracy_figures(s).front().y_names.front(), "rts = kalman");
  EXPECT_EQ(article_tables(s).front().rows.front().front().text, "rts = kalman");
  EXPECT_THAT(method_legend(s), Contains("`mean = median`: what mean does"));
}

// A row that stands for two methods is shown first as each of them would be.
TEST(FirstScreen, SharedRowsStayAmongTheFirst) {
  std::vector<std::pair<std::string, double>> methods{{"nonlinear", 9.0}, {"mean", 5.0}, {"mine", 5.0}};
  for (int m = 0; m < 12; ++m) methods.emplace_back("method " + std::to_string(m), 6.0 + m);
  const ResultsSummary s = shown_summary(chosen(6, methods));
  EXPECT_THAT(leading_methods(s, "walking"), Contains("mean"));
  EXPECT_THAT(accuracy_figures(s).front().y_names, Contains("mean = mine"));
  EXPECT_THAT(paper_comparison(s).front(), StartsWith("**No**"));
}

TEST(FirstScreen, WithoutABestMethodItIsSaidWhyWhereAnyMethodAnswers) {
  ResultsSummary s = chosen(1, {{"mean", 5.0}, {"rts", 4.0}});
  s.best.clear();
  EXPECT_THAT(accuracy_findings(s),
              Contains(HasSubstr("too short for an interval, so no method is called best")));
  s.numbers = {};
  EXPECT_THAT(accuracy_findings(s), Not(Contains(HasSubstr("too short"))));
}

TEST(FirstScreen, TheTableOfErrorsHasARowAJointGroupAndMethod) {
  const std::vector<Table> tables = accuracy_shown(chosen(6, {{"mean", 5.0}, {"rts", 4.0}}), {}).tables;
  const auto errors =
      std::ranges::find_if(tables, [](const Table& table) { return table.id.starts_with("accuracy"); });
  ASSERT_NE(errors, tables.end());
  ASSERT_EQ(errors->rows.size(), 2u);
  EXPECT_EQ(errors->rows[1][1].text, "rts");
  EXPECT_NEAR(errors->rows[1][4].number.value_or(kNaN), 4.0, 1e-9);
}

TEST(FirstScreen, ChecksAreShownInTheUnitOfPeople) {
  TrackingSummary s;
  for (const auto& [unit, value] : {std::pair{"m", 0.123}, {"rad", 0.1}, {"s", 0.25}, {"1", 0.5}})
    s.checks.push_back(
        {.take = "t", .subject = "k1", .what = "w", .unit = unit, .value = value, .limit = value});
  const Table table = checks_table(s);
  const auto shown = [&](std::size_t row) {
    return fmt::format("{:.{}f} {}", table.rows[row][3].number.value_or(kNaN), table.rows[row][3].decimals,
                       table.rows[row][5].text);
  };
  EXPECT_EQ(shown(0), "12.30 cm");
  EXPECT_EQ(shown(1), "5.73 degrees");
  EXPECT_EQ(shown(2), "0.250 s");
  EXPECT_EQ(shown(3), "0.500 ratio");
}

TEST(FirstScreen, AStudyNamedAsItsCampaignIsNamedOnce) {
  EXPECT_EQ(accuracy_shown(chosen(6, {{"mean", 5.0}}), {}).title, "chosen");
}

}  // namespace
}  // namespace trilat
