// SPDX-License-Identifier: MIT
#include "pipeline/errors/error_changes.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "reports/tables.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

// The wrist of one person a number, in centimetres; without the others that results hold.
std::filesystem::path results_of(const ScratchFolder& folder, const std::string& name,
                                 const std::vector<double>& errors_cm, const std::string& person = "p",
                                 const std::string& alignment = "none") {
  ResultsSummary s;
  s.study = "study";
  s.campaign = "campaign";
  s.methods = {"mean"};
  s.conditions = {"walking"};
  s.groups = {"wrist"};
  s.alignments = {alignment};
  for (std::size_t p = 0; p < errors_cm.size(); ++p)
    add_row({fmt::format("t{}", p), fmt::format("{}{}", person, p), "walking", "wrist", "wrist_left", "mean",
             10, 10, 0.01 * errors_cm[p]},
            s);
  std::filesystem::create_directories(folder / name);
  write_results(folder / name, s);
  return folder / name;
}

// The differences are 1, 2 and 3 cm: 2 +- 4.303 / sqrt(3) by Student's t with two degrees of freedom.
TEST(ErrorChanges, OfTheSamePeopleAreThoseOfTheirDifferences) {
  const ScratchFolder folder;
  const auto before = results_of(folder, "before", {4.0, 8.0, 12.0}),
             after = results_of(folder, "after", {5.0, 10.0, 15.0});
  const auto changes = changes_between({before, after});
  ASSERT_TRUE(changes);
  EXPECT_TRUE(changes->paired);
  ASSERT_EQ(changes->rows.size(), 1u);
  const ErrorChange& change = changes->rows[0];
  EXPECT_NEAR(change.before_m, 0.08, 1e-12);
  EXPECT_NEAR(change.after_m, 0.10, 1e-12);
  EXPECT_NEAR(change.difference_m, 0.02, 1e-12);
  EXPECT_NEAR(change.high_m, 0.02 + 0.04303 / std::sqrt(3.0), 1e-5);
  EXPECT_EQ(change.clusters, 3u);
  EXPECT_NEAR(change.standard_error_m, 0.01 / std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(change.p_value, 1.0 - std::sqrt(12.0 / 14.0),
              1e-9);  // t = sqrt(12), in closed form for two degrees
  EXPECT_FALSE(change.is_real());
  EXPECT_THAT(changes_sentences(*changes).at(0), HasSubstr("**0 of 1**"));
}

TEST(ErrorChanges, OfOtherPeopleHaveTheSpreadOfBoth) {
  const ScratchFolder folder;
  const auto before = results_of(folder, "before", {4.0, 8.0, 12.0});
  const auto same = changes_between({before, results_of(folder, "same", {5.0, 10.0, 15.0})}),
             others = changes_between({before, results_of(folder, "others", {5.0, 10.0, 15.0}, "q")});
  ASSERT_TRUE(same && others);
  EXPECT_FALSE(others->paired);
  EXPECT_NEAR(others->rows[0].difference_m, 0.02, 1e-12);
  EXPECT_GT(others->rows[0].high_m, 2.0 * same->rows[0].high_m - 0.02);
  // variances 16 and 25 cm^2 of three each: standard error sqrt(41 / 3) cm, 3.8 degrees of freedom, t(3)
  // = 3.1824
  EXPECT_NEAR(others->rows[0].standard_error_m, 0.01 * std::sqrt(41.0 / 3.0), 1e-9);
  EXPECT_EQ(others->rows[0].degrees, 3u);
  EXPECT_NEAR(others->rows[0].high_m, 0.02 + 0.031824 * std::sqrt(41.0 / 3.0), 1e-5);
}

TEST(ErrorChanges, OfAnAverageAreThoseOfTheGroupsThatBothAnswer) {
  ErrorsByJoint before{{"walking"}, {"mean"}, {"wrist", "ankle"}, {}};
  for (int p = 0; p < 3; ++p)
    for (const char* group : {"wrist", "ankle"})
      before.rows.push_back({fmt::format("t{}", p), fmt::format("p{}", p), "walking", group,
                             std::string(group) + "_left", "mean", 10, 10, 0.04});
  ErrorsByJoint after = before;
  for (TakeJointRow& row : after.rows) {
    if (row.group == "ankle") row.answered = 0;
    row.mae_m = row.group == "ankle" ? kNaN : row.mae_m + 0.01;
  }
  const auto changes = changes_between(before, after);
  ASSERT_TRUE(changes);
  const auto average = std::ranges::find(changes->rows, std::string(kAverageGroup), &ErrorChange::group);
  ASSERT_NE(average, changes->rows.end());
  EXPECT_NEAR(average->difference_m, 0.01, 1e-12);
  EXPECT_THAT(average->without, testing::ElementsAre("ankle"));
}

TEST(ErrorChanges, ARealOneIsSaidToBeOne) {
  const ScratchFolder folder;
  const auto changes = changes_between(
      {results_of(folder, "before", {4.0, 8.0, 12.0}), results_of(folder, "after", {3.0, 6.9, 11.1})});
  ASSERT_TRUE(changes);
  EXPECT_TRUE(changes->rows[0].is_real());
  EXPECT_EQ(changes_table(*changes).rows[0].back().text, "better");
  EXPECT_THAT(changes_sentences(*changes).at(1), HasSubstr("-1.00 cm"));
}

TEST(ErrorChanges, AreBetweenTwoAlone) {
  const ScratchFolder folder;
  const auto one = results_of(folder, "one", {4.0, 8.0});
  EXPECT_FALSE(changes_between({one}));
  EXPECT_FALSE(changes_between({one, one, one}));
}

TEST(ErrorChanges, AreNotBetweenTwoMeasuresOfError) {
  const ScratchFolder folder;
  const std::vector<double> errors_cm{4.0, 8.0};
  const auto one = results_of(folder, "one", errors_cm);
  EXPECT_TRUE(changes_between({one, results_of(folder, "same", errors_cm)}));
  EXPECT_FALSE(changes_between({one, results_of(folder, "aligned", errors_cm, "p", "rigid")}));
}

}  // namespace
}  // namespace trilat
