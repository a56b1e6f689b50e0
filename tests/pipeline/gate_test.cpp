// SPDX-License-Identifier: MIT
#include <fstream>
#include <utility>

#include <gmock/gmock.h>

#include "datasets/results/gate_history.h"
#include "datasets/results/studies/sweep_summary.h"
#include "pipeline/gate/accept_results.h"
#include "pipeline/gate/compare_results.h"
#include "pipeline/gate/found_results.h"
#include "pipeline/gate/judge_cells.h"
#include "tests/pipeline/made_results.h"
#include "tests/pipeline/program.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

GateReport compare(const Nights& nights) { return compare_results(nights.now(), nights.before(), {{}, {}}); }

std::vector<GateFinding> alarms_of(const GateReport& report) {
  std::vector<GateFinding> alarms;
  for (const GateFinding& f : report.findings)
    if (f.alarm) alarms.push_back(f);
  return alarms;
}

TEST(Gate, IsQuietAboutIdenticalResults) {
  Nights nights;
  nights.write({});
  const GateReport report = compare(nights);
  EXPECT_THAT(report.findings, IsEmpty());
  ASSERT_THAT(report.studies, SizeIs(1));
  EXPECT_EQ(report.studies[0].state, StudyState::identical);
  const Ended ended = nights.gate();
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, AllOf(HasSubstr("QUIET"), HasSubstr("identical to the byte: walks")));
}

TEST(Gate, NamesTheMethodAndJointGroupThatGotWorse) {
  Nights nights;
  nights.write(larger_errors(1.02));
  const auto alarms = alarms_of(compare(nights));
  ASSERT_THAT(alarms, SizeIs(2));  // the head and the average
  for (const GateFinding& f : alarms) {
    EXPECT_EQ(f.kind, FindingKind::accuracy);
    EXPECT_EQ(f.method, "nonlinear");
  }
  EXPECT_EQ(alarms[0].group, "head");
  EXPECT_NEAR(alarms[0].change.percent, 2.0, 1e-4);
  EXPECT_EQ(alarms[0].n, 3000u);
  EXPECT_EQ(alarms[0].clusters, 10u);
  EXPECT_EQ(alarms[1].group, "average");
  EXPECT_NEAR(alarms[1].change.percent, 1.0, 0.05);
  const Ended ended = nights.gate();
  EXPECT_EQ(ended.code, 1) << ended.err;
  EXPECT_THAT(ended.out, AllOf(HasSubstr("REGRESSION"), HasSubstr("nonlinear: larger errors"),
                               HasSubstr("walking, head"), HasSubstr("--method nonlinear")));
  EXPECT_THAT(nights.gate({"--method", "nonlinear"}).out, HasSubstr("+2.00"));
}

TEST(Gate, ToleratesLessThanTheSmallestEffectAndToldEffectsCanBeSet) {
  Nights nights;
  nights.write(larger_errors(1.005));
  EXPECT_EQ(nights.gate().code, 0);
  EXPECT_EQ(nights.gate({"--smallest-effect", "0.2"}).code, 1);
}

TEST(Gate, TellsWhatIsBetterWithoutAnAlarm) {
  Nights nights;
  nights.write(larger_errors(0.9));
  const Ended ended = nights.gate();
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.out, AllOf(HasSubstr("QUIET"), HasSubstr("nonlinear: smaller errors")));
}

TEST(Gate, AMethodIsNotBetterForLeavingOutItsWorstSamples) {
  Nights nights;
  nights.write([](MadeSample& s) {
    if (s.method == 1 && s.error_m > 0.0595) s.answered = false;  // the worst twentieth
  });
  const auto alarms = alarms_of(compare(nights));
  ASSERT_THAT(alarms, Not(IsEmpty()));
  for (const GateFinding& f : alarms) {
    EXPECT_EQ(f.kind, FindingKind::coverage);
    EXPECT_EQ(f.method, "nonlinear");
    EXPECT_LT(f.now, f.before);
  }
  EXPECT_THAT(nights.gate().out, HasSubstr("answers less often"));
}

TEST(Gate, OneTakeThatIsNotAnsweredAnyMoreIsEnough) {
  Nights nights;
  nights.write([](MadeSample& s) {
    if (s.method == 1 && s.take == 3) s.answered = false;
  });
  const auto alarms = alarms_of(compare(nights));
  ASSERT_THAT(alarms, Not(IsEmpty()));
  EXPECT_EQ(alarms[0].kind, FindingKind::coverage);
  EXPECT_THAT(alarms[0].note, HasSubstr("take p3-walking: 0 of 300 left"));
}

TEST(Gate, OneParticipantIsJudgedByTimeBlocks) {
  Nights nights;
  MadeStudy study;
  study.participants = 1;
  study.instants = 1200;
  nights.write(larger_errors(1.03), study);
  EXPECT_THAT(alarms_of(compare(nights)), Not(IsEmpty()));
}

TEST(Gate, ATakeThatFailsIsAnAlarmWithItsReason) {
  Nights nights;
  nights.write({});
  MadeStudy study;
  study.takes_failed = 1;
  write_made_results(nights.folder / "now", study, larger_errors(1.0001));
  const auto alarms = alarms_of(compare(nights));
  ASSERT_THAT(alarms, SizeIs(1));
  EXPECT_EQ(alarms[0].kind, FindingKind::failure);
  EXPECT_THAT(alarms[0].note, HasSubstr("p0-walking (session.h5: is damaged)"));
}

TEST(Gate, RefusesABaselineOfAnotherConfigurationAndSaysWhatDiffers) {
  Nights nights;
  nights.write({});
  MadeStudy study;
  study.rate_hz = 60.0;
  write_made_results(nights.folder / "before", study);
  expect_refused(nights.gate(), "/study/rate_hz is 30.0 here and 60.0 there");
}

TEST(Gate, RefusesOtherRecordingsButNotOtherwiseSimulatedOnes) {
  Nights nights;
  MadeStudy study;
  study.simulated = false;
  nights.write({}, study);
  study.input_sha256 = "11";
  write_made_results(nights.folder / "now", study);
  expect_refused(nights.gate(), R"(/inputs/0/sha256 is "11" here and "00" there)");
  study.simulated = true;
  write_made_results(nights.folder / "now", study);
  study.input_sha256 = "00";
  write_made_results(nights.folder / "before", study);
  const Ended ended = nights.gate();
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("the simulated recordings themselves are others"));
}

TEST(Gate, RefusesWhatIsUnfinishedEmptyOrOfAnotherVersion) {
  Nights nights;
  nights.write({});
  write_made_results(nights.folder / "several" / "walks");
  std::filesystem::remove(nights.folder / "several" / "walks" / "summary.json");
  const auto refusal = [&](const std::string& results) {
    return run_trilat(nights.folder, {"gate", results, "--baseline", nights.before()});
  };
  expect_refused(refusal((nights.folder / "several").string()),
                 "walks: is unfinished: 10 of 10 items are there");
  std::filesystem::create_directories(nights.folder / "empty");
  expect_refused(refusal((nights.folder / "empty").string()), "holds no results");
  expect_refused(refusal((nights.folder / "nowhere").string()), "is no folder");
  Json summary = read_json(nights.folder / "now" / "summary.json");
  Json other = summary;
  other["version"] = 99;
  write_file(nights.folder / "now" / "summary.json", other.dump());
  expect_refused(nights.gate(), "/version: is another version");
  other = summary;
  other["cells"] = Json::array();
  write_file(nights.folder / "now" / "summary.json", other.dump());
  expect_refused(nights.gate(), "/cells: is empty");
}

TEST(Gate, TellsStudiesThatOnlyOneSideHasAndAlarmsForALostOne) {
  ScratchFolder folder;
  MadeStudy other;
  other.name = "runs";
  write_made_results(folder / "now/walks");
  write_made_results(folder / "before/walks");
  write_made_results(folder / "now/runs", other);
  const auto gate = [&] {
    return run_trilat(folder,
                      {"gate", (folder / "now").string(), "--baseline", (folder / "before").string()});
  };
  Ended ended = gate();
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("new, not in the baseline: runs"));
  std::filesystem::rename(folder / "now/runs", folder / "before/runs");
  ended = gate();
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.out, AllOf(HasSubstr("only in the baseline: runs"), HasSubstr("runs, fails")));
}

TEST(Gate, GivesTheSameVerdictWithAnyNumberOfThreads) {
  Nights nights;
  nights.write(larger_errors(1.015));
  Json one = only_json(nights.gate({"--json", "--threads", "1"}));
  Json three = only_json(nights.gate({"--json", "--threads", "3"}));
  one.erase("time");
  three.erase("time");
  EXPECT_EQ(one, three);
  EXPECT_EQ(one["verdict"], "regression");
}

TEST(Gate, AcceptingNeedsAReasonAndIsRemembered) {
  Nights nights;
  nights.write(larger_errors(1.1));
  const std::string history = (nights.folder / "history.jsonl").string();
  expect_refused(nights.gate({"--accept", " "}), "needs a reason");
  EXPECT_EQ(nights.gate({"--history", history}).code, 1);
  const Ended ended = nights.gate({"--accept", "a <better> model", "--history", history});
  EXPECT_EQ(ended.code, 0) << ended.err;
  const auto accepted = read_beside<AcceptedBaseline>(nights.before());
  ASSERT_TRUE(accepted.has_value());
  EXPECT_EQ(accepted->reason, "a <better> model");
  EXPECT_THAT(accepted->replaces_sha256, SizeIs(64));
  EXPECT_EQ(nights.gate({"--history", history}).code, 0);
  const History read = read_history(history);
  ASSERT_THAT(read.entries, SizeIs(3));
  EXPECT_FALSE(read.entries[0].quiet);
  EXPECT_TRUE(read.entries[1].accepted);
  EXPECT_TRUE(read.entries[2].quiet);
}

TEST(Gate, TheFirstBaselineIsAcceptedTooAndNeverOverSomethingElse) {
  Nights nights;
  nights.write({});
  std::filesystem::remove_all(nights.folder / "before");
  expect_refused(nights.gate(), "--accept");
  EXPECT_EQ(nights.gate({"--accept", "first"}).code, 0);
  EXPECT_EQ(nights.gate().code, 0);
  std::filesystem::remove_all(nights.folder / "before");
  std::filesystem::create_directories(nights.folder / "before");
  write_file(nights.folder / "before" / "thesis.txt", "years of work");
  expect_refused(nights.gate({"--accept", "first"}), "holds no results");
  EXPECT_TRUE(std::filesystem::exists(nights.folder / "before" / "thesis.txt"));
}

TEST(Gate, ATornLastLineOfTheHistoryIsToldAndReplaced) {
  Nights nights;
  nights.write({});
  const auto history = nights.folder / "history.jsonl";
  ASSERT_EQ(nights.gate({"--history", history.string()}).code, 0);
  {
    std::ofstream file(history, std::ios::app);
    file << R"({"format": "trilat.history", "ver)";
  }
  const Ended ended = nights.gate({"--history", history.string()});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("history.jsonl:2: is torn"));
  EXPECT_THAT(read_history(history).entries, SizeIs(2));
  EXPECT_EQ(read_history(history).torn, "");
  write_file(history, "not JSON\n" + read_file(history));
  expect_refused(nights.gate({"--history", history.string()}), "history.jsonl:1");
}

TEST(Gate, ManyAlarmsAreSummedUpByMethod) {
  GateReport report;
  const auto alarm = [&](const char* study, const char* method, const char* group) {
    GateFinding finding;
    finding.kind = FindingKind::accuracy;
    finding.direction = Direction::worse;
    finding.alarm = true;
    finding.study = study;
    finding.method = method;
    finding.group = group;
    report.findings.push_back(finding);
  };
  for (const char* study : {"a", "b", "c"}) alarm(study, "nonlinear", "head");
  EXPECT_THAT(morning_text(report), Not(HasSubstr("by method")));  // three headings tell
  alarm("a", "nonlinear", "wrist");
  alarm("c", "mean", "head");
  EXPECT_THAT(morning_text(report),
              HasSubstr("\nby method: nonlinear (4 places in 3 studies), mean (1 places in 1 studies)\n"));
}

TEST(Gate, WritesJunitThatAnXmlReaderTakes) {
  Nights nights;
  nights.write(larger_errors(1.1));
  const auto junit = nights.folder / "gate.xml";
  EXPECT_EQ(nights.gate({"--junit", junit.string()}).code, 1);
  const std::string xml = read_file(junit);
  EXPECT_THAT(xml, AllOf(HasSubstr("tests=\"3\" failures=\"2\""), HasSubstr("<failure type=\"worse\"")));
  GateReport odd;
  GateFinding finding;
  finding.alarm = true;
  finding.study = "a<b>&\"c\"";
  finding.what = std::string("bell \a, byte \xff");
  odd.findings.push_back(finding);
  EXPECT_THAT(gate_junit(odd),
              AllOf(HasSubstr("a&lt;b&gt;&amp;&quot;c&quot;"), Not(HasSubstr("\a")), Not(HasSubstr("\xff"))));
}

}  // namespace
}  // namespace trilat
