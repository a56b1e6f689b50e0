// SPDX-License-Identifier: MIT

#include <set>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "pipeline/claims/judge_claims.h"
#include "reports/tables.h"
#include "tests/pipeline/made_campaign.h"
#include "tests/support/scratch.h"
#include "tests/support/trials.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

Estimate estimate(double value, double standard_error, std::size_t clusters = 16) {
  return {value, standard_error, clusters};
}

PaperClaim claim_named(const char* id) {
  return {id, "where", "text", "printed", ClaimKind::tested, "table3", more_than(10), "why", {}};
}
ClaimNumber number_of(const MeasuredNumber& number, const ClaimBound& bound, const char* id = "c") {
  return claim_number(id, {.what = "w", .unit = "%", .number = number}, bound);
}
JudgedClaim judge(const std::vector<ClaimNumber>& numbers) {
  return judge_claims(std::array{claim_named("c")}, numbers)[0];
}
ClaimVerdict verdict(const MeasuredNumber& number, const ClaimBound& bound) {
  return judge({number_of(number, bound)}).verdict;
}

// The spread that a stored interval shows is the one that it was made from.
TEST(Claims, AStoredNumberIsJudgedByItsInterval) {
  const Estimate made = estimate(0.2, 0.03, 7);
  const Estimate read = estimate_of({{}, made.value, made.low(), made.high(), 100, 7});
  EXPECT_EQ(read.value, 0.2);
  EXPECT_EQ(read.clusters, 7u);
  EXPECT_NEAR(read.standard_error, 0.03, 1e-12);
  EXPECT_TRUE(std::isnan(estimate_of({{}, 0.2, kNaN, kNaN, 100, 1}).standard_error));
}

TEST(Claims, AChanceIsAtMostOneOnTheOtherSide) {
  const ClaimPValues above = p_values_of(estimate(0.2, 0.01), more_than(10)),
                     below = p_values_of(estimate(0.05, 0.01), more_than(10));
  EXPECT_LT(above.holds, 1e-6);
  EXPECT_EQ(above.fails, 1.0);
  EXPECT_EQ(below.holds, 1.0);
  EXPECT_LT(below.fails, 1e-3);
}

TEST(Claims, AreDecidedWhereTheIntervalLeavesTheMarginOut) {
  for (const double off : {2.14, 2.12}) {  // quantile of 15 degrees: 2.1314
    const ClaimVerdict decided = off > 2.1314 ? ClaimVerdict::holds : ClaimVerdict::undecided,
                       failed = off > 2.1314 ? ClaimVerdict::does_not_hold : ClaimVerdict::undecided;
    EXPECT_EQ(verdict(estimate(0.1 + 0.01 * off, 0.01), more_than(10)), decided);
    EXPECT_EQ(verdict(estimate(0.1 - 0.01 * off, 0.01), more_than(10)), failed);
    EXPECT_EQ(verdict(estimate(0.1 - 0.01 * off, 0.01), less_than(10)), decided);
    EXPECT_EQ(verdict(estimate(0.1 - 0.01 * off, 0.01), within(10)), decided);
    EXPECT_EQ(verdict(estimate(-0.1 + 0.01 * off, 0.01), within(10)), decided);
    EXPECT_EQ(verdict(estimate(-0.1 - 0.01 * off, 0.01), within(10)), failed);
  }
  EXPECT_EQ(verdict(estimate(0.5, kNaN, 1), more_than(10)), ClaimVerdict::undecided);  // no interval
  EXPECT_EQ(verdict(estimate(0.5, 0.0), more_than(10)),
            ClaimVerdict::undecided);  // nothing is known of the spread
}

TEST(Claims, OfSeveralNumbersAllHaveToHold) {
  const ClaimNumber yes = number_of(estimate(0.3, 0.01), more_than(10)),
                    no = number_of(estimate(0.05, 0.01), more_than(10)),
                    open = number_of(estimate(0.11, 0.01), more_than(10));
  EXPECT_EQ(judge({yes, yes}).verdict, ClaimVerdict::holds);
  EXPECT_EQ(judge({yes, no}).verdict, ClaimVerdict::does_not_hold);
  EXPECT_EQ(judge({yes, open}).verdict, ClaimVerdict::undecided);
}

TEST(Claims, ManyThatAreTestedAreEachHarderToDecide) {
  const PaperClaim one = claim_named("c"), two = claim_named("d");
  const MeasuredNumber likely = estimate(0.125, 0.01);  // p = 0.025
  const std::vector<ClaimNumber> numbers{number_of(likely, more_than(10)),
                                         number_of(likely, more_than(10), "d")};
  EXPECT_EQ(judge({numbers[0]}).verdict, ClaimVerdict::holds);
  const std::vector<JudgedClaim> both =
      judge_claims(std::array{one, two, claim_named("not measured")}, numbers);
  EXPECT_EQ(both[0].verdict, ClaimVerdict::holds);  // 0.049
  EXPECT_NEAR(both[0].p, 2.0 * judge({numbers[0]}).p, 1e-12);
  const std::vector<JudgedClaim> three =
      judge_claims(std::array{one, two, claim_named("e")},
                   std::vector{numbers[0], numbers[1], number_of(likely, more_than(10), "e")});
  EXPECT_EQ(three[0].verdict, ClaimVerdict::undecided);
}

// All of 16 runs right: no more is known than that the share of runs is above 79 %.
TEST(Claims, SharesHaveExactIntervalsAndNeverAnImpossibleProbability) {
  const std::vector<double> frames(16, 1000.0);
  const ClaimNumber all = number_of(estimate_share(frames, frames), more_than(99.99));
  EXPECT_EQ(all.value, 100.0);
  EXPECT_EQ(all.high, 100.0);
  EXPECT_NEAR(all.low, 79.4, 0.1);
  EXPECT_EQ(judge({all}).verdict, ClaimVerdict::undecided);
  EXPECT_EQ(verdict(estimate_share(frames, frames), more_than(50)), ClaimVerdict::holds);
  EXPECT_EQ(verdict(estimate_share(std::vector<double>(16, 10.0), frames), more_than(50)),
            ClaimVerdict::does_not_hold);
  std::vector<double> taken = frames;
  taken[3] = 980.0;
  const ClaimNumber most = number_of(estimate_share(taken, frames), more_than(99.98));
  EXPECT_LT(most.low, most.value);
  EXPECT_LT(most.high, 100.0);
  EXPECT_GT(most.p_holds, 0.0);
}

// With no spread 16 runs show 83 % at most (1 - p = 0.95 two-sided), so more than 99 % is not undecided.
TEST(Claims, AShareThatSoFewClustersCannotShowIsNotTested) {
  const std::vector<double> frames(16, 1000.0);
  PaperClaim claim = claim_named("c");
  const auto judged = [&](const std::vector<double>& taken, double percent) {
    claim.bound = more_than(percent);
    return judge_claims(std::array{claim},
                        std::vector{number_of(estimate_share(taken, frames), more_than(percent))})[0];
  };
  EXPECT_EQ(judged(frames, 99.0).verdict, ClaimVerdict::cannot_test);
  EXPECT_THAT(judged(frames, 99.0).reason,
              HasSubstr("16 participants cannot show more than 99 %: 368 would be"));
  EXPECT_EQ(judged(frames, 75.0).verdict, ClaimVerdict::holds);
  EXPECT_EQ(judged(std::vector<double>(16, 500.0), 99.0).verdict, ClaimVerdict::does_not_hold);
}

TEST(Claims, WhatIsListedWholeHasNoProbability) {
  PaperClaim join_names = claim_named("c");
  join_names.kind = ClaimKind::join_names;
  const auto of = [&](double share) {
    return judge_claims(std::array{join_names}, std::vector{number_of(share, more_than(50))})[0];
  };
  EXPECT_EQ(of(0.6).verdict, ClaimVerdict::holds);
  EXPECT_EQ(of(0.4).verdict, ClaimVerdict::does_not_hold);
  EXPECT_TRUE(std::isnan(of(0.6).p));
}

// Of each participant the errors (cm) of the methods, at all joints.
MadeStudy walking(const std::vector<std::pair<std::string, std::vector<double>>>& methods,
                  std::vector<std::string> joints = {"head", "shoulder_left", "elbow_left", "wrist_right"}) {
  std::vector<std::string> names;
  SensorSetGroup singles{"single", 1, {}};
  for (const auto& [name, errors_cm] : methods) {
    names.push_back(name);
    if (name.starts_with("single ")) singles.methods.push_back(name);
  }
  MadeStudy study("table3", std::move(joints), names);
  study.names.families = {singles};
  for (std::size_t p = 0; p < methods.front().second.size(); ++p)
    study.add("p" + std::to_string(p), "walking",
              [&](std::uint32_t, std::uint32_t m, Subset) { return 0.01 * methods[m].second[p]; });
  return study;
}

std::vector<ClaimNumber> numbers_of(const std::string& claim, const std::vector<ClaimNumber>& all) {
  std::vector<ClaimNumber> of;
  std::ranges::copy_if(all, std::back_inserter(of), [&](const ClaimNumber& n) { return n.claim == claim; });
  return of;
}

TEST(Claims, MethodsAreComparedByPencil) {
  const MadeStudy study =
      walking({{"nonlinear", {4.0, 8.0, 12.0, 16.0}}, {"linear", {5.2, 10.0, 15.6, 20.0}}});
  const ClaimNumber number = numbers_of("better_than_linear", study.claims()).at(0);
  EXPECT_NEAR(number.value, 100.0 * (1.2 + 2.0 + 3.6 + 4.0) / 40.0, 1e-9);
  EXPECT_EQ(number.clusters, 4u);
  EXPECT_EQ(number.over, "participants");
  EXPECT_EQ(number.bound, "more than 1 %");
  EXPECT_NEAR(number.compared, 1.0, 1e-12);
}

// numbers.csv holds the number of each claim, and the share of samples that both of its methods answer.
TEST(Claims, TheirNumbersAreNumbersOfTheStudy) {
  MadeStudy study("table3", {"head", "shoulder_left", "elbow_left", "wrist_right"}, {"nonlinear", "linear"});
  for (const char* who : {"a", "b", "c"})
    study.add(
        who, "walking", [](std::uint32_t, std::uint32_t m, Subset) { return m == 0 ? 0.05 : 0.06; },
        [](std::uint32_t m) { return m == 0 ? MadeStudy::kSamples : MadeStudy::kSamples / 4; });
  const ResultsSummary summary = study.summary();
  const NumberKey key{.condition = "walking",
                      .group = kPaperJoints,
                      .method = "linear",
                      .against = "nonlinear",
                      .alignment = "mean",
                      .measure = "distance"};
  const Number* relative = summary.numbers.find(key.with({.statistic = "relative_difference"}));
  ASSERT_TRUE(relative);
  EXPECT_NEAR(relative->value, 0.2, 1e-12);
  EXPECT_EQ(relative->n, 3u * 4u * MadeStudy::kSamples / 4u);
  EXPECT_EQ(summary.numbers.value(key.with({.statistic = "share_compared"})), 0.25);
  EXPECT_EQ(numbers_of("better_than_linear", claim_numbers(summary)).at(0).compared, 0.25);
}

// Own data with legs mapped: the paper's average is over head, shoulder, elbow and wrist.
TEST(Claims, AreJudgedAtThePapersJoints) {
  MadeStudy study("table3", {"head", "shoulder_left", "elbow_left", "wrist_right", "ankle_left"},
                  {"nonlinear", "linear"});
  for (const char* who : {"a", "b", "c"})
    study.add(who, "walking", [&](std::uint32_t j, std::uint32_t m, Subset) {
      return j == 4 && m == 1 ? 0.5 : m == 1 ? 0.06 : 0.05;
    });
  EXPECT_NEAR(numbers_of("better_than_linear", study.claims()).at(0).value, 20.0, 1e-9);
  const MadeStudy few =
      walking({{"nonlinear", {4.0, 5.0, 6.0}}, {"linear", {5.0, 6.0, 7.0}}}, {"head", "wrist_left"});
  EXPECT_EQ(numbers_of("better_than_linear", few.claims()).at(0).missing,
            "a study of walking with the joints of head, shoulder, elbow, wrist");
}

TEST(Claims, WithoutTruthNothingIsAnError) {
  MadeStudy study = walking({{"nonlinear", {4.0, 5.0, 6.0}}, {"linear", {5.0, 6.0, 7.0}}});
  study.names.truth = kLeftOutTruth;
  for (const ClaimNumber& number : study.claims()) EXPECT_THAT(number.missing, HasSubstr("motion capture"));
  const auto judged = judge_claims(paper_claims(), study.claims());
  const auto linear = std::ranges::find(judged, "better_than_linear", &JudgedClaim::id);
  EXPECT_EQ(linear->verdict, ClaimVerdict::cannot_test);
  EXPECT_THAT(linear->reason, HasSubstr("needs motion capture"));
}

TEST(Claims, ASilentMethodIsNamed) {
  MadeStudy study("table3", {"head", "shoulder_left", "elbow_left", "wrist_right"}, {"nonlinear", "linear"});
  study.names.campaign = "three";
  for (const char* who : {"a", "b", "c"})
    study.add(
        who, "walking", [](std::uint32_t, std::uint32_t, Subset) { return 0.05; },
        [](std::uint32_t m) { return m == 1 ? 0u : MadeStudy::kSamples; });
  EXPECT_EQ(numbers_of("better_than_linear", study.claims()).at(0).missing,
            "linear answers nothing on the rig of three");
}

TEST(Claims, TheBestOfAFamilyIsChosenOnOtherParticipants) {
  // each is best on the one on whom the other is worst: who chooses by the others always gets the worse
  const MadeStudy study = walking(
      {{"nonlinear", {4.0, 4.0, 4.0}}, {"single k1", {1.0, 8.0, 8.0}}, {"single k2", {8.0, 1.0, 8.1}}});
  const auto numbers = numbers_of("combining_by_trilateration", study.claims());
  ASSERT_EQ(numbers.size(), 2u);
  EXPECT_NEAR(numbers[0].value, 100.0 * (34.1 / 24.0 - 1.0), 1e-9);
  EXPECT_NEAR(numbers[1].value, 100.0 * ((8.0 + 8.0 + 8.0) / 12.0 - 1.0), 1.0);
}

TEST(Claims, AbruptMovementsAreComparedWithTheRest) {
  MadeStudy study("table3", {"head", "shoulder_left", "elbow_left", "wrist_right"}, {"nonlinear"});
  study.abrupt = 1.25;
  for (int p = 0; p < 8; ++p)
    study.add("p" + std::to_string(p), "walking",
              [&](std::uint32_t, std::uint32_t, Subset) { return 0.04 + 0.0001 * (p - 3.5); });
  const ClaimNumber number = numbers_of("abrupt_joints_worse", study.claims()).at(0);
  EXPECT_NEAR(number.value, 25.0, 0.01);
  EXPECT_LT(number.p_holds, 0.01);
}

TEST(Claims, TheWristOfTheFigureIsJudgedByItsLargestError) {
  const MadeStudy study = walking({{"nonlinear", {4.0, 0.5, 12.0, 16.0}}});
  const auto numbers = numbers_of("wrist_deviation", study.claims());
  ASSERT_EQ(numbers.size(), 2u);
  EXPECT_NEAR(numbers[0].value, (4.0 + 0.5 + 12.0 + 16.0) / 4.0, 1e-9);
  EXPECT_EQ(numbers[0].bound, "less than 5 cm");
  EXPECT_NEAR(numbers[1].value, 0.5 * (4.0 + 0.5 + 12.0 + 16.0) / 4.0, 1e-9);
  EXPECT_EQ(numbers[1].bound, "less than 1 cm");
}

// The way of the fastest joint in 5 ms: half a metre a second, of an error of 4 cm.
TEST(Claims, WhatAClockCostsIsTheWayOfTheFastestJoint) {
  const MadeStudy study = walking({{"nonlinear", {4.0, 4.0, 4.0}}});
  const ClaimNumber number = numbers_of("clock_good_enough", study.claims()).at(0);
  EXPECT_NEAR(number.value, 100.0 * 0.5 * 0.005 / 0.04, 1e-9);
  EXPECT_EQ(number.bound, "less than 10 %");
}

TEST(Claims, PlacesAreComparedByPencil) {
  MadeStudy study("table3", {"head", "shoulder_left", "elbow_left", "wrist_right"}, {"nonlinear"});
  for (const char* who : {"a", "b", "c"})
    study.add(who, "walking", [](std::uint32_t j, std::uint32_t, Subset) { return 0.01 * (j + 1); });
  const auto numbers = numbers_of("wrist_worst", study.claims());
  ASSERT_EQ(numbers.size(), 3u);
  EXPECT_NEAR(numbers[0].value, 100.0, 1e-9);  // against the shoulder
  EXPECT_NEAR(numbers[1].value, 300.0, 1e-9);  // the head
  EXPECT_NEAR(numbers[2].value, 100.0 / 3.0, 1e-9);
  EXPECT_EQ(numbers[0].what, "nonlinear: wrist against shoulder");
  MadeStudy occluded("table2",
                     {"shoulder_left", "elbow_left", "wrist_left", "hip_left", "knee_left", "ankle_left"},
                     {"nonlinear", "nonlinear, occlusion corrected"});
  for (const char* who : {"a", "b", "c"})
    for (const char* activity : {"arm_swing", "leg_crossing"})
      occluded.add(who, activity, [&](std::uint32_t, std::uint32_t, Subset subset) {
        return (activity[0] == 'l' ? 0.03 : 0.02) * (subset == Subset::occluded ? 2.0 : 1.0);
      });
  EXPECT_NEAR(numbers_of("legs_worse", occluded.claims()).at(0).value, 50.0, 1e-9);
}

// Four recordings of sensors, each with so many frames below 4 ms.
TEST(Claims, SharesOfClocksAreOverRecordingsAndSensors) {
  ClocksSummary clocks;
  clocks.paper = "clocks";
  clocks.campaign = "bench";
  const NumberKey key{
      .method = "corrected, causal", .measure = "clock_error", .statistic = "share_below_4ms"};
  for (const char* sensor : {"k1", "k2", "k3", "k4"})
    clocks.numbers.add({key.with({.group = sensor, .take = "walk"}), 0.75, kNaN, kNaN, 1000});
  clocks.numbers.add({key, 0.1, kNaN, kNaN, 4000});  // of all together: not counted again
  const ClaimNumber number = numbers_of("clock_below_4ms", claim_numbers(clocks)).at(0);
  EXPECT_EQ(number.value, 75.0);
  EXPECT_EQ(number.clusters, 4u);
  EXPECT_EQ(number.over, "recordings of a sensor");
  EXPECT_THAT(numbers_of("clock_below_2ms", claim_numbers(clocks)).at(0).missing,
              HasSubstr("share_below_2ms of clock_error"));
}

// A sweep of another grid, one of the paper's grid that is nowhere near Table I, and one that is.
TEST(Claims, OfTheSweepCountInterpretationsThatAreNearTheTable) {
  SweepSummary sweep;
  sweep.paper = "table1";
  sweep.cells.resize(8);
  const NumberKey key{.measure = "interpretations"};
  const auto threshold = [&] { return numbers_of("threshold", claim_numbers(sweep)).at(0); };
  EXPECT_THAT(threshold().missing, HasSubstr("a sweep over the thresholds"));
  sweep.numbers.add({key.with({.statistic = "share_near"}), 0.0, kNaN, kNaN, 8});
  EXPECT_THAT(threshold().missing, HasSubstr("whose every error is that near"));
  sweep.numbers.add({key.with({.statistic = "share"}), 0.75, kNaN, kNaN, 4});
  EXPECT_EQ(threshold().value, 75.0);
  EXPECT_EQ(threshold().what, "of 4 acceptable interpretations of 8");
  EXPECT_EQ(threshold().p_holds, 0.0);
}

TEST(Claims, OfTheWandAreThoseOfTheStatedDistances) {
  CalibrationSummary calibration;
  calibration.paper = "calibration";
  const NumberKey key{.condition = "bench",
                      .group = "inside",
                      .method = "corrected by the mid-range",
                      .measure = "ball_distance"};
  calibration.numbers.add({key.with({.statistic = "mean"}), 0.0173, 0.0, 0.0373, 50, 8});
  EXPECT_THAT(numbers_of("wand_accuracy", claim_numbers(calibration)).at(0).missing,
              HasSubstr("stated distances"));
  calibration.stated_distances = "bench";
  const ClaimNumber number = numbers_of("wand_accuracy", claim_numbers(calibration)).at(0);
  EXPECT_NEAR(number.value, 1.0, 1e-9);  // less 0.73 cm
  EXPECT_NEAR(number.high, 3.0, 1e-9);
  EXPECT_EQ(number.unit, "cm");
  EXPECT_EQ(number.bound, "within 0.24 cm");
}

TEST(Claims, AreHonestWithoutResults) {
  for (const JudgedClaim& claim : judge_claims(paper_claims(), {})) {
    EXPECT_THAT(claim.verdict, testing::AnyOf(ClaimVerdict::cannot_test, ClaimVerdict::contradicts))
        << claim.id;
    EXPECT_FALSE(claim.reason.empty()) << claim.id;
  }
}

TEST(Claims, EachThatIsTestedSaysByWhichNumbersOfWhichStudyAndWithWhichBound) {
  std::set<std::string> ids;
  for (const PaperClaim& claim : paper_claims()) {
    EXPECT_TRUE(ids.insert(claim.id).second) << claim.id;
    const bool is_judged = claim.kind == ClaimKind::tested || claim.kind == ClaimKind::join_names;
    EXPECT_EQ(is_judged, !claim.numbers.empty()) << claim.id;
    EXPECT_EQ(is_judged, std::ranges::count(words<PaperStudy>, claim.study) == 1) << claim.id;
    for (const ClaimedNumber& number : claim.numbers) {
      EXPECT_TRUE(number.bound.has_value() || claim.bound.has_value()) << claim.id;
      EXPECT_FALSE(number.key.measure.empty() || number.key.statistic.empty()) << claim.id;
    }
  }
  EXPECT_THAT(compared_with("table3"),
              testing::UnorderedElementsAre("mean", "nonlinear", "nonlinear, each three",
                                            "nonlinear mended, C = 1e-4"));
  EXPECT_THAT(compared_with("none"), testing::IsEmpty());
}

TEST(Claims, TwoResultsOfOneStudyAreAnError) {
  const ScratchFolder folder;
  const MadeStudy study = walking({{"nonlinear", {4.0, 5.0, 6.0}}});
  for (const char* name : {"one", "other"}) {
    std::filesystem::create_directories(folder / name);
    write_results(folder / name, study.names);
  }
  EXPECT_TRUE(judge_paper({folder / "one"}));
  EXPECT_THAT(message_of([&] {
                judge_paper({folder / "one", folder / "other"});
              }),
              testing::AllOf(HasSubstr("table3"), HasSubstr((folder / "one").string())));
}

// Whether a campaign in which nothing differs, or by the margin exactly, has a verdict that is false.
bool has_false_verdict(const std::vector<JudgedClaim>& claims) {
  return std::ranges::any_of(claims, [](const JudgedClaim& c) {
    const bool is_absolute = c.id == "wrist_deviation" || c.id == "clock_good_enough" || c.numbers.empty();
    const bool says_same = !c.numbers.empty() && c.numbers.front().bound.starts_with("within");
    return !is_absolute && c.verdict == (says_same ? ClaimVerdict::does_not_hold : ClaimVerdict::holds);
  });
}

double share_of_false_campaigns(const MadeCampaign& made) {
  const std::uint64_t campaigns = trials(500);
  double share = 0.0;
  for (std::uint64_t k = 0; k < campaigns; ++k)
    if (has_false_verdict(judge_claims(paper_claims(), made.draw(k))))
      share += 1.0 / static_cast<double>(campaigns);
  return share;
}

TEST(Claims, OfFiveHundredCampaignsWithoutADifferenceAtMostOneInTwentyHasAFalseVerdict) {
  const double most = 0.05 + slack(0.05, trials(500));
  EXPECT_LE(share_of_false_campaigns({}), most);
  EXPECT_LE(share_of_false_campaigns({.participants = 4}), most);
  // as large as the margin, where chance is hardest to tell
  EXPECT_LE(share_of_false_campaigns({.factor = 1.01}), most);
  EXPECT_LE(share_of_false_campaigns({.participant_spread = 0.5, .method_spread = 0.4}), most);
}

TEST(Claims, OfCampaignsWithALargeDifferenceMostVerdictsAreTrue) {
  int holds = 0, measured = 0;
  for (const JudgedClaim& c : judge_claims(paper_claims(), MadeCampaign{.factor = 1.4}.draw(1))) {
    measured += !c.numbers.empty();
    holds += c.verdict == ClaimVerdict::holds;
  }
  EXPECT_GE(measured, 15);
  EXPECT_GE(holds, 5);
}

TEST(ClaimsTable, ShowsEveryNumberWithItsInterval) {
  PaperFindings findings;
  findings.claims = judge_claims(paper_claims(), MadeCampaign{}.draw(1));
  const Table table = claims_table(findings);
  ASSERT_EQ(table.rows.size(), findings.claims.size());
  for (std::size_t k = 0; k < table.rows.size(); ++k) {
    EXPECT_EQ(table.rows[k][1].text, name_of(findings.claims[k].verdict));
    if (findings.claims[k].numbers.empty()) continue;
    EXPECT_THAT(table.rows[k][4].text, HasSubstr(" to ")) << k;
  }
  EXPECT_THAT(table.title, Not(HasSubstr("simulated")));
}

TEST(ClaimsTable, ATinyProbabilityIsNotPrintedAsZero) {
  PaperFindings findings;
  findings.claims = {judge({number_of(estimate(0.5, 0.01), more_than(10))})};
  EXPECT_EQ(claims_table(findings).rows[0][6].text, "< 0.0001");
}

}  // namespace
}  // namespace trilat
