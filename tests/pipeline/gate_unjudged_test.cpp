// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "datasets/results/gate_history.h"
#include "pipeline/gate/compare_results.h"
#include "pipeline/gate/found_results.h"
#include "tests/pipeline/made_results.h"
#include "tests/pipeline/program.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

// Errors of other recordings, twice as large, but not alike in both participants: chance to whoever sees two.
TEST(GateUnjudged, OtherRecordingsOfTwoParticipantsAreNotQuiet) {
  MadeStudy study;
  study.participants = 2;
  Nights nights(study, {});
  study.input_sha256 = "11";
  write_made_results(nights.folder / "now", study,
                     [](MadeSample& s) { s.error_m *= s.take == 0 ? 1.8 : 2.2; });
  const auto history = nights.folder / "history.csv";
  const Ended ended = nights.gate({"--history", history.string()});
  EXPECT_EQ(ended.code, 3) << ended.out;
  EXPECT_THAT(ended.out, testing::StartsWith("NOT JUDGED: 2 participants in walks"));
  EXPECT_THAT(ended.out, Not(HasSubstr("QUIET")));
  const std::vector<Night> read = read_history(history);
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].verdict, NightVerdict::not_judged);
  EXPECT_THAT(read[0].not_judged, testing::ElementsAre("walks"));
  EXPECT_THAT(nights.gate({"--json"}).out, HasSubstr("\"verdict\": \"not_judged\""));
}

TEST(GateUnjudged, OtherRecordingsOfTwoParticipantsWithTheSameNumbersAreQuiet) {
  MadeStudy study;
  study.participants = 2;
  Nights nights(study, {});
  study.input_sha256 = "11";
  write_made_results(nights.folder / "now", study);
  EXPECT_EQ(nights.gate().code, 0);
}

// The smallest change that would be found is computed from methods that changed: an unchanged one has no
// spread.
TEST(GateUnjudged, WhatCanBeFoundIsOfTheMethodsThatChanged) {
  ErrorsByJoint before{{"walking"}, {"a", "b", "c"}, {"head", "wrist"}, {}};
  for (int p = 0; p < 10; ++p)
    for (const char* joint : {"head", "wrist"})
      for (const char* method : {"a", "b", "c"}) {
        const std::string name = "p" + std::to_string(p);
        before.rows.push_back(
            {name + "-walk", name, "walking", joint, joint, method, 100, 100, 0.05 + 0.001 * p});
      }
  ErrorsByJoint now = before;
  for (std::size_t k = 2; k < now.rows.size(); k += 3)
    now.rows[k].mae_m *= 1.1 + 0.001 * static_cast<double>(k % 7);
  GateReport report;
  const double found_percent = compare_unpaired("walks", before, now, {}, report);
  EXPECT_GT(found_percent, 0.0);
  EXPECT_LT(found_percent, 10.0);
  for (const GateFinding& finding : report.findings) EXPECT_EQ(finding.method, "c");
}

// Of ten people whose errors all grow by about a third; the size that can be found is said.
TEST(GateUnjudged, OtherRecordingsOfTenParticipantsAreJudged) {
  MadeStudy study;
  Nights nights(study, {});
  study.input_sha256 = "11";
  write_made_results(nights.folder / "now", study, [](MadeSample& s) {
    if (s.method == 1) s.error_m *= 1.3 + 0.02 * static_cast<double>(s.take % 4);
  });
  const Ended ended = nights.gate();
  EXPECT_EQ(ended.code, 1) << ended.out;
  EXPECT_THAT(ended.out, testing::AllOf(testing::StartsWith("REGRESSION: walks, nonlinear, walking"),
                                        HasSubstr("judged between 10 participants"), HasSubstr(", p ")));
}

// Ten takes of which all but the first `same` were recorded again, and errors that `spoil` changes.
Ended gate_of_mixed(std::size_t same, const Spoil& spoil) {
  MadeStudy study;
  Nights nights(study, {});
  study.input_sha256 = "11";
  study.same_takes = same;
  write_made_results(nights.folder / "now", study, spoil);
  return nights.gate();
}

// The eight takes that are the same do not make the night quiet.
TEST(GateUnjudged, FewTakesOfOtherRecordingsAreNotQuietBesideOthersThatAre) {
  const Ended ended = gate_of_mixed(8, [](MadeSample& s) {
    if (s.take >= 8) s.error_m *= s.take == 8 ? 1.8 : 2.2;
  });
  EXPECT_EQ(ended.code, 3) << ended.out;
  EXPECT_THAT(ended.out, testing::AllOf(testing::StartsWith("NOT JUDGED: 2 participants in walks"),
                                        HasSubstr("other recordings of 2 takes, p8-walking")));
}

TEST(GateUnjudged, TakesOfTheSameRecordingsAreJudgedBesideOthers) {
  const Ended ended = gate_of_mixed(8, [](MadeSample& s) {
    if (s.take < 8 && s.method == 1) s.error_m *= 1.03;
  });
  EXPECT_EQ(ended.code, 1) << ended.out;
  EXPECT_THAT(ended.out, testing::StartsWith("REGRESSION: walks, nonlinear, walking"));
}

TEST(GateUnjudged, ManyTakesOfOtherRecordingsAreJudgedBesideOneThatIsTheSame) {
  const Ended ended = gate_of_mixed(1, [](MadeSample& s) {
    if (s.take > 0 && s.method == 1) s.error_m *= 1.3 + 0.02 * static_cast<double>(s.take % 4);
  });
  EXPECT_EQ(ended.code, 1) << ended.out;
  EXPECT_THAT(ended.out, testing::AllOf(testing::StartsWith("REGRESSION: walks, nonlinear, walking"),
                                        HasSubstr("judged between 9 participants")));
}

// No take has a namesake in the baseline: other persons, who are judged or said not to be.
TEST(GateUnjudged, OtherPersonsAreNeverQuietUnseen) {
  for (const std::size_t persons : {2, 10}) {
    MadeStudy study;
    study.participants = persons;
    Nights nights(study, {});
    study.input_sha256 = "11";
    study.first_person = 20;
    write_made_results(nights.folder / "now", study, [](MadeSample& s) {
      if (s.method == 1) s.error_m *= 1.5 + 0.02 * static_cast<double>(s.take % 4);
    });
    const Ended ended = nights.gate();
    EXPECT_EQ(ended.code, persons == 2 ? 3 : 1) << ended.out;
  }
}

}  // namespace
}  // namespace trilat
