// SPDX-License-Identifier: MIT
#include "pipeline/cli/accuracy_outcome.h"

#include <gmock/gmock.h>

#include "tests/pipeline/program.h"
#include "tests/reports/summaries.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

SummaryCell cell(const std::string& method, const std::string& group, double mae_m, std::uint64_t answered) {
  SummaryCell c = cell_of(method, group, mae_m, answered);
  c.asked = 1000;
  c.mae_low_m = mae_m - 0.002;
  c.mae_high_m = mae_m + 0.004;
  return c;
}

DifferenceCell difference(const std::string& method, double percent, double low_m, double high_m) {
  DifferenceCell d;
  d.method = method;
  d.condition = "walking";
  d.group = kAverageGroup;
  d.alignment = "mean";
  d.low_m = low_m;
  d.high_m = high_m;
  d.percent_of_reference = percent;
  d.percent_low = percent - 5.0;
  return d;
}

ResultsSummary small() {
  ResultsSummary s;
  s.campaign = "gait";
  s.takes = 3;
  s.takes_failed = 1;
  s.participants = 2;
  s.methods = {"nonlinear", "mean", "linear"};
  s.reference = "nonlinear";
  s.conditions = {"walking"};
  s.groups = {"head", "wrist"};
  s.alignments = {"mean"};
  for (const char* group : {"head", "wrist", kAverageGroup}) {
    s.cells.push_back(cell("nonlinear", group, 0.059, 1000));
    s.cells.push_back(cell("mean", group, 0.041, 999));
    s.cells.push_back(cell("linear", group, 0.063, 870));
  }
  s.differences = {difference("mean", -31.0, -0.02, -0.01), difference("linear", 7.0, -0.001, 0.01)};
  return s;
}

TEST(Outcome, ShowsTheBestFirstWithItsIntervalAndWhetherItDiffers) {
  const std::string text = outcome_text(small());
  EXPECT_THAT(
      text,
      HasSubstr("gait, recorded: 2 of 3 takes, 2 participants\nmean error in cm (alignment mean), ± half "
                "of the 95 % interval"));
  EXPECT_THAT(text, HasSubstr("mean            -31 %            4.1±0.3"));
  EXPECT_THAT(text, HasSubstr("linear              ≈    87.0 %  6.3±0.3"));
  EXPECT_LT(text.find("mean     "), text.find("nonlinear  "));
  EXPECT_THAT(text, HasSubstr("from nonlinear, of the average, where both answer"));
}

TEST(Outcome, IsAtMostAHundredColumnsWideAndSaysWhatIsLeftOut) {
  ResultsSummary s = small();
  for (int g = 0; g < 12; ++g) {
    s.groups.push_back("a long name of a group " + std::to_string(g));
    s.cells.push_back(cell("mean", s.groups.back(), 0.1, 1000));
  }
  const std::string text = outcome_text(s);
  std::size_t longest = 0, begin = 0;
  for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1)
    longest = std::max(longest, end - begin);
  EXPECT_LE(longest, 110u);  // bytes: a sign of ± or ≈ has two or three
  EXPECT_THAT(text, HasSubstr("more of the joint groups: --tables"));
}

TEST(Outcome, SaysOnceWhatTheBestIsLikeAndWhoIsSilent) {
  ResultsSummary s = small();
  s.differences = {difference("mean", -31.0, -0.02, 0.01)};
  s.best = {{"walking", kAverageGroup, "mean", {"nonlinear"}}};
  for (SummaryCell& c : s.cells)
    if (c.method == "linear") c.answered = 0;
  const std::string text = outcome_text(s);
  EXPECT_THAT(text, HasSubstr("mean errs least, by 4.1 cm (3.9 to 4.5); 1 other is not told apart\n"
                              "from it (nonlinear)."));
  EXPECT_THAT(text, HasSubstr("warning: linear answers nothing in walking."));
}

TEST(Outcome, OfOneMethodHasNoDifferenceAndOfNothingSaysSo) {
  ResultsSummary s = small();
  s.methods = {"nonlinear"};
  EXPECT_THAT(outcome_text(s), Not(HasSubstr("difference")));
  s.cells.clear();
  EXPECT_THAT(outcome_text(s), HasSubstr("no sample was answered"));
}

TEST(Outcome, IsWhatRunShowsAndTablesShowsAll) {
  const ScratchFolder folder;
  write_file(folder / "simulation.json", R"({"format": "trilat.simulation", "version": 1, "participants": 2,
      "activities": [{"name": "walking", "duration_s": 2}]})");
  write_file(folder / "study.json",
             R"({"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "s",
      "methods": [{"method": "nonlinear"}, {"method": "mean"}]})");
  ASSERT_EQ(run_trilat(folder, {"simulate", folder / "simulation.json", "-o", folder / "camp"}).code, 0);
  std::vector<std::string> words{"run", folder / "study.json", "--campaign", folder / "camp",
                                 "-o",  folder / "results"};
  const Ended brief = run_trilat(folder, words);
  EXPECT_THAT(brief.out, AllOf(HasSubstr("simulated: 2 of 2 takes"), HasSubstr("next: trilat report"),
                               Not(HasSubstr("| "))));
  EXPECT_LT(std::ranges::count(brief.out, '\n'), 20);
  words.push_back("--tables");
  EXPECT_THAT(run_trilat(folder, words).out, HasSubstr("**Position error by joint group and method"));
}

}  // namespace
}  // namespace trilat
