// SPDX-License-Identifier: MIT
#include "reports/claims/claims.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/paper/printed_tables.h"
#include "pipeline/claims/judge_claims.h"
#include "tests/pipeline/made_campaign.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

// A study of walking at one joint: each participant's errors of methods, in centimetres.
PaperEvidence walking(const std::vector<std::pair<std::string, std::vector<double>>>& methods) {
  ResultsSummary s;
  s.conditions = {"walking"};
  s.groups = {"head"};
  s.reference = methods.front().first;
  MethodFamily singles{"single", 1, {}};
  for (const auto& [method, errors_cm] : methods) {
    s.methods.push_back(method);
    if (method.starts_with("single ")) singles.methods.push_back(method);
    for (std::size_t p = 0; p < errors_cm.size(); ++p) {
      TakeJointRow row{"t", "p" + std::to_string(p), "walking", "head", "head", method, 10, 10};
      row.mae_m = 0.01 * errors_cm[p];
      row.both = {10, row.mae_m, 0.01 * methods.front().second[p]};
      row.complete = row.both;
      s.by_take.push_back(row);
    }
  }
  s.families = {singles};
  PaperEvidence evidence;
  evidence.walking = s;
  return evidence;
}

// One claim with these members, beside the usual ones.
Json document(const std::vector<std::string>& claims) {
  Json rows = Json::array();
  for (const std::string& members : claims)
    rows.push_back(
        parse_json(R"({"id": "c", "where": "w", "claim": "c", "printed": "p", )" + members + "}", "c"));
  return {{"source", "s"}, {"claims", rows}};
}
std::vector<JudgedClaim> judged(const std::vector<std::string>& claims, const PaperEvidence& evidence) {
  return judge_claims(document(claims), "claims.json", evidence);
}
JudgedClaim judge(const std::string& members, const PaperEvidence& evidence) {
  return judged({members}, evidence)[0];
}

const std::string kBetter =
    R"("more_than": 10, "parts": [{"statistic": "errors", "of": "b", "against": "a"}])";
const std::string kSame = R"("within": 10, "parts": [{"statistic": "errors", "of": "b", "against": "a"}])";

TEST(Claims, HoldWhereTheWholeIntervalLiesOnTheirSideOfTheMargin) {
  const std::vector<double> a{4.0, 8.0, 12.0, 16.0};
  const auto b = [](double low, double high) {
    return std::vector{4.0 * low, 8.0 * high, 12.0 * low, 16.0 * high};
  };
  const JudgedClaim holds = judge(kBetter, walking({{"a", a}, {"b", b(1.29, 1.31)}}));
  EXPECT_EQ(holds.verdict, "holds");
  EXPECT_NEAR(holds.parts.at(0).estimate.value, 100.0 * (16.0 * 0.29 + 24.0 * 0.31) / 40.0, 1e-9);
  EXPECT_GT(holds.parts[0].estimate.low, 25.0);
  EXPECT_EQ(holds.parts[0].bound, "more than 10 %");
  EXPECT_EQ(judge(kBetter, walking({{"a", a}, {"b", b(1.05, 1.07)}})).verdict, "does not hold");
  EXPECT_EQ(judge(kBetter, walking({{"a", a}, {"b", b(0.95, 1.35)}})).verdict, "undecided");
  EXPECT_EQ(judge(kSame, walking({{"a", a}, {"b", b(0.98, 1.02)}})).verdict, "holds");
  EXPECT_EQ(judge(kSame, walking({{"a", a}, {"b", b(0.7, 0.75)}})).verdict, "does not hold");
  EXPECT_EQ(judge(kSame, walking({{"a", a}, {"b", b(0.8, 1.2)}})).verdict, "undecided");
  EXPECT_EQ(judge(kBetter, walking({{"a", {4.0}}, {"b", {8.0}}})).verdict, "undecided");  // no interval
}

TEST(Claims, TheReferenceMayStandFirst) {
  const PaperEvidence evidence = walking({{"a", {5.0, 5.1, 4.9, 5.0}}, {"b", {4.0, 4.1, 3.9, 4.0}}});
  const auto part =
      judge(R"("more_than": 1, "parts": [{"statistic": "errors", "of": "a", "against": "b"}])", evidence)
          .parts.at(0);
  EXPECT_NEAR(part.estimate.value, 25.0, 1e-9);  // of b's error
}

TEST(Claims, OfSeveralNumbersAllHaveToHold) {
  const PaperEvidence evidence =
      walking({{"a", {4.0, 8.0, 12.0}}, {"b", {5.2, 10.4, 15.7}}, {"c", {4.0, 8.1, 12.0}}});
  const auto both = [](const char* one, const char* two) {
    return fmt::format(R"("more_than": 10, "parts": [{{"statistic": "errors", "of": "{}", "against": "a"}},
                          {{"statistic": "errors", "of": "{}", "against": "a"}}])",
                       one, two);
  };
  EXPECT_EQ(judge(both("b", "b"), evidence).verdict, "holds");
  EXPECT_EQ(judge(both("b", "c"), evidence).verdict, "does not hold");
}

TEST(Claims, ManyConfirmatoryOnesAreEachHarderToDecide) {
  const PaperEvidence evidence =
      walking({{"a", {4.0, 8.0, 12.0, 16.0}}, {"b", {5.0, 9.6, 15.2, 19.0}}, {"c", {4.0, 9.6, 11.0, 18.0}}});
  const std::string one = R"("confirmatory": true, )" + kBetter;
  const JudgedClaim alone = judge(one, evidence);
  EXPECT_EQ(alone.verdict, "holds");
  const auto crowd = judged({one, one, one, one}, evidence);
  EXPECT_EQ(crowd[0].verdict, "undecided");
  EXPECT_NEAR(crowd[0].chance, 4.0 * alone.chance, 1e-12);
  EXPECT_THAT(crowd[0].reason, HasSubstr("participants would decide it, here are 4"));
}

TEST(Claims, WithoutAnySampleThatBothAnswerNothingIsDecided) {
  PaperEvidence evidence = walking({{"a", {4.0, 8.0, 12.0, 16.0}}, {"b", {8.0, 16.0, 24.0, 32.0}}});
  evidence.walking->campaign = "three";
  for (TakeJointRow& row : evidence.walking->by_take)
    if (row.method == "b") {
      row.answered = 0;
      row.both = {};
    }
  const JudgedClaim silent = judge(kBetter, evidence);
  EXPECT_EQ(silent.verdict, kCannotTest);
  EXPECT_EQ(silent.reason, "b answers nothing on the rig of three");
  for (TakeJointRow& row : evidence.walking->by_take) row.answered = 5;
  EXPECT_EQ(judge(kBetter, evidence).reason, "b and a never answer the same sample");
}

// The interval that is shown lies on one side of the margin just when the verdict says so.
TEST(Claims, VerdictsFollowFromTheIntervalsThatAreShown) {
  std::map<std::string, int> verdicts;
  const auto side_of =
      [](const ClaimPart& part) {  // 1: where the claim holds, -1: where it fails, 0: neither
        const bool within = part.bound.starts_with("within"), less = part.bound.starts_with("less");
        const double margin = std::stod(part.bound.substr(within ? 7 : 10));
        const double low = part.estimate.low, high = part.estimate.high;
        if (within) return low >= -margin && high <= margin ? 1 : low > margin || high < -margin ? -1 : 0;
        return (less ? high <= margin : low >= margin) ? 1 : (less ? low >= margin : high <= margin) ? -1 : 0;
      };
  for (std::uint64_t k = 0; k < 60; ++k)
    for (const MadeCampaign& made : {MadeCampaign{}, MadeCampaign{.participants = 4, .factor = 1.05},
                                     MadeCampaign{.factor = 1.01}, MadeCampaign{.factor = 1.4}}) {
      for (const JudgedClaim& claim : judge_claims(printed_claims(), "claims.json", made.draw(k))) {
        if (claim.parts.empty()) continue;
        int holding = 0, failing = 0;
        for (const ClaimPart& part : claim.parts) {
          const int side = std::isfinite(part.estimate.low) ? side_of(part) : 0;
          holding += side > 0;
          failing += side < 0;
        }
        const std::string verdict = claim.verdict.substr(0, claim.verdict.find(','));
        ++verdicts[verdict];
        EXPECT_EQ(verdict == kHolds, holding == static_cast<int>(claim.parts.size()))
            << claim.id << " " << claim.verdict;
        EXPECT_EQ(verdict == kDoesNotHold, failing > 0) << claim.id << " " << claim.verdict;
      }
    }
  EXPECT_GT(verdicts[kHolds], 20);
  EXPECT_GT(verdicts[kDoesNotHold], 20);
  EXPECT_GT(verdicts[kUndecided], 20);
}

TEST(Claims, AVerdictSaysWhenItHoldsOnlyWhereBothAnswerAndByWhichSize) {
  PaperEvidence evidence = walking({{"a", {4.0, 8.0, 12.0, 16.0}}, {"b", {5.0, 10.1, 14.9, 20.0}}});
  const std::string paper = R"("more_than": 10, "parts": [{"statistic": "errors", "of": "b", "against": "a",
                                                          "paper": 75}])";
  EXPECT_EQ(judge(paper, evidence).verdict, "holds, but a third of the size");
  for (TakeJointRow& row : evidence.walking->by_take)
    if (row.method == "b") row.complete.mae_m = row.complete.reference_mae_m;
  EXPECT_EQ(judge(kBetter, evidence).verdict, "holds, where both answer");
}

TEST(Claims, TheBestOfAFamilyIsChosenOnOtherParticipants) {
  // each is best on the one on whom the other is worst: who chooses by the others always gets the worse
  const PaperEvidence evidence =
      walking({{"a", {4.0, 4.0, 4.0}}, {"single k1", {1.0, 8.0, 8.0}}, {"single k2", {8.0, 1.0, 8.1}}});
  const auto part = [&](const char* of) {
    return judge(
               fmt::format(
                   R"("more_than": 1, "parts": [{{"statistic": "errors", "of": "{}", "against": "a"}}])", of),
               evidence)
        .parts.at(0);
  };
  EXPECT_NEAR(part("best of single").estimate.value, 100.0 * ((8.0 + 8.0 + 8.0) / 12.0 - 1.0), 1.0);
  EXPECT_NEAR(part("single").estimate.value, 100.0 * (34.1 / 24.0 - 1.0), 1e-9);
}

TEST(Claims, AMethodThatNeverAnswersIsNotTheBestOfItsFamily) {
  PaperEvidence evidence =
      walking({{"a", {4.0, 4.0, 4.0}}, {"single k1", {1.0, 1.0, 1.0}}, {"single k2", {8.0, 8.0, 8.1}}});
  for (TakeJointRow& row : evidence.walking->by_take)
    if (row.method == "single k1") {
      row.answered = 0;
      row.both = {};
      row.complete = {10, row.complete.reference_mae_m, row.complete.reference_mae_m};
    }
  const JudgedClaim claim =
      judge(R"("more_than": 1, "parts": [{"statistic": "errors", "of": "best of single", "against": "a"}])",
            evidence);
  EXPECT_NEAR(claim.parts.at(0).estimate.value, 100.0 * (24.1 / 12.0 - 1.0), 1e-9);
}

TEST(Claims, SayHowManyParticipantsWouldDecideThem) {
  const ContrastEstimate e{20.0, 10.0, 16};  // spread 40: a one-sided margin of 0 needs some 34
  const auto needed = clusters_needed(e, {ClaimBound::Side::more_than, 0.0}, 0.05);
  ASSERT_TRUE(needed);
  EXPECT_NEAR(static_cast<double>(*needed), std::pow((1.96 + 0.84) * 40.0 / 20.0, 2), 3.0);
  EXPECT_FALSE(clusters_needed({1e-3, 10.0, 16}, {ClaimBound::Side::more_than, 0.0}, 0.05));
}

TEST(Claims, ThePapersOwnRowsCanAllBeReadAndAreHonestWithoutResults) {
  for (const JudgedClaim& claim : judge_claims(printed_claims(), "claims.json", {})) {
    EXPECT_THAT(claim.verdict, testing::AnyOf(kCannotTest, kContradicts)) << claim.id;
    EXPECT_FALSE(claim.reason.empty()) << claim.id;
    EXPECT_TRUE(claim.parts.empty()) << claim.id;
  }
}

TEST(Claims, WhatIsSaidToContradictItselfIsARowOfTheAuditThatDiffers) {
  const Table audit = audit_table();
  const Json claims = printed_claims();
  int found = 0;
  for (const Json& row : claims["claims"])
    for (const Json& part : row["parts"]) {
      if (part["statistic"] != "printed") continue;
      ++found;
      EXPECT_TRUE(std::ranges::any_of(audit.rows, [&](const auto& r) {
        return r[1].text == part["erratum"] && r[5].text == "differs";
      })) << part;
    }
  EXPECT_GE(found, 4);
}

TEST(Claims, ARowThatCannotBeReadIsNamed) {
  const auto message = [](const std::string& members) { return message_of([&] { judge(members, {}); }); };
  EXPECT_THAT(message(R"("parts": [{"statistic": "guess"}])"),
              HasSubstr("claims.json /claims/0/parts/0/statistic"));
  EXPECT_THAT(message(R"("parts": [{"statistic": "errors", "of": "a"}])"), HasSubstr("/parts/0"));
  EXPECT_THAT(message(R"("more_than": 1, "within": 2, "parts": [])"), HasSubstr("is a second bound"));
  const PaperEvidence evidence = walking({{"a", {1.0, 2.0}}, {"b", {1.0, 2.0}}});
  EXPECT_THAT(message_of([&] {
                judge(R"("parts": [{"statistic": "errors", "of": "b", "against": "a"}])", evidence);
              }),
              HasSubstr("needs a bound"));
}

// Whether a campaign in which nothing differs, or by the margin exactly, has a verdict that is false.
bool has_false_verdict(const std::vector<JudgedClaim>& claims) {
  return std::ranges::any_of(claims, [](const JudgedClaim& c) {
    const bool says_same = !c.parts.empty() && c.parts.front().bound.starts_with("within");
    return c.confirmatory && c.verdict.starts_with(says_same ? kDoesNotHold : kHolds);
  });
}

int false_campaigns(const MadeCampaign& made, int campaigns) {
  int count = 0;
  const Json claims = printed_claims();
  for (int k = 0; k < campaigns; ++k)
    count += has_false_verdict(judge_claims(claims, "claims.json", made.draw(static_cast<std::uint64_t>(k))));
  return count;
}

TEST(Claims, OfFiveHundredCampaignsWithoutADifferenceAtMostOneInTwentyHasAFalseVerdict) {
  EXPECT_LE(false_campaigns({}, 500), 25);
  EXPECT_LE(false_campaigns({.participants = 4}, 500), 25);
  EXPECT_LE(false_campaigns({.factor = 1.01}, 500),
            25);  // as large as the margin, where chance is hardest to tell
  EXPECT_LE(false_campaigns({.participant_spread = 0.5, .method_spread = 0.4}, 500), 25);
}

TEST(Claims, OfCampaignsWithALargeDifferenceMostVerdictsAreTrue) {
  const auto claims = judge_claims(printed_claims(), "claims.json", MadeCampaign{.factor = 1.4}.draw(1));
  int holds = 0, confirmatory = 0;
  for (const JudgedClaim& c : claims) {
    confirmatory += c.confirmatory;
    holds += c.confirmatory && c.verdict.starts_with(kHolds);
  }
  EXPECT_GE(confirmatory, 12);
  EXPECT_GE(holds, 5);
}

TEST(ClaimsTable, SaysWhatIsSimulatedAndShowsEveryNumberWithItsInterval) {
  PaperFindings findings{MadeCampaign{}.draw(1), {}, {}};
  findings.claims = judge_claims(printed_claims(), "claims.json", findings.evidence);
  const Table table = claims_table(findings);
  EXPECT_EQ(table.rows.size(), findings.claims.size());
  EXPECT_THAT(table.title, HasSubstr("simulated"));
  EXPECT_THAT(table.notes.back(), HasSubstr("simulated"));
  for (std::size_t k = 0; k < table.rows.size(); ++k) {
    if (!findings.claims[k].parts.empty()) {
      EXPECT_THAT(table.rows[k][3].text, HasSubstr(" to ")) << k;
    }
  }
  EXPECT_THAT(claims_table({}).title, Not(HasSubstr("simulated")));
}

// Errors of 4 cm in the slower halves and of 5 cm, somewhat more or less by person, in the faster ones.
TEST(Claims, ErrorsOfFastJointsAreComparedWithThoseOfSlowOnes) {
  PaperEvidence evidence = walking({{"a", std::vector<double>(8, 4.5)}});
  double more_cm = -0.07;
  for (TakeJointRow& row : evidence.walking->by_take) {
    row.by_speed = {5, 5, 0.04, 0.01 * (5.0 + more_cm)};
    more_cm += 0.02;
  }
  const JudgedClaim claim =
      judge(R"("more_than": 10, "parts": [{"statistic": "speed", "method": "a"}])", evidence);
  EXPECT_THAT(claim.verdict, StartsWith("holds"));
  ASSERT_EQ(claim.parts.size(), 1u);
  EXPECT_NEAR(claim.parts[0].estimate.value, 25.0, 1e-9);
  for (TakeJointRow& row : evidence.walking->by_take) row.by_speed = {};
  EXPECT_EQ(judge(R"("more_than": 10, "parts": [{"statistic": "speed", "method": "a"}])", evidence).verdict,
            "cannot be tested here");
}

}  // namespace
}  // namespace trilat
