// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include <gmock/gmock.h>

#include "datasets/results/gate_history.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/clocks/clocks_study.h"
#include "pipeline/gate/compare_results.h"
#include "pipeline/gate/found_results.h"
#include "pipeline/sweep/sweep_summary.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/made_results.h"
#include "tests/pipeline/program.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

GateReport compare(const Nights& nights) { return compare_results(nights.now(), nights.before()); }

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
  EXPECT_THAT(ended.out, AllOf(HasSubstr("QUIET"), HasSubstr("every number the same: walks")));
}

// A method that ends before hard samples loses answers and gets no better by it.
TEST(Gate, ErrorsAreOfTheSamplesThatBothNightsAnswer) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", walking_spec(2, 4.0));
  const auto run = [&](const char* night, int iterations) {
    const std::string methods = fmt::format(
        R"([{{"name": "n", "method": "nonlinear", "threshold_cm2": 1e-6, "max_iterations": {}}}])",
        iterations);
    execute_study(study_of(R"("alignments": ["none"], "methods": )" + methods), campaign, folder / night, {});
  };
  run("before", 200);
  run("now", 4);
  const auto is_accuracy = [](const GateFinding& f) { return f.kind == FindingKind::accuracy; };
  const GateReport report = compare_results(folder / "now", folder / "before");
  EXPECT_TRUE(std::ranges::any_of(alarms_of(report),
                                  [](const GateFinding& f) { return f.kind == FindingKind::coverage; }));
  EXPECT_TRUE(std::ranges::none_of(report.findings, is_accuracy));
  EXPECT_THAT(report.studies.at(0).note, Not(HasSubstr("keeps no samples")));
  std::filesystem::remove_all(folder / "before/items");
  const GateReport without = compare_results(folder / "now", folder / "before");
  EXPECT_TRUE(std::ranges::any_of(without.findings, is_accuracy));
  EXPECT_THAT(without.studies.at(0).note, HasSubstr("one side keeps no samples"));
}

TEST(Gate, NamesTheMethodAndJointGroupThatGotWorse) {
  Nights nights;
  nights.write(larger_errors(1.019));
  const auto alarms = alarms_of(compare(nights));
  ASSERT_THAT(alarms, SizeIs(1));  // the average grew by less than one percent
  EXPECT_EQ(alarms[0].kind, FindingKind::accuracy);
  EXPECT_EQ(alarms[0].method, "nonlinear");
  EXPECT_EQ(alarms[0].group, "head");
  EXPECT_NEAR(alarms[0].percent, 1.9, 1e-9);
  const Ended ended = nights.gate();
  EXPECT_EQ(ended.code, 1) << ended.err;
  EXPECT_THAT(ended.out,
              testing::StartsWith("REGRESSION: walks, nonlinear, walking, head: larger errors, +1.9 %, 5."));
}

TEST(Gate, TheWorstAlarmComesFirst) {
  Nights nights;
  nights.write([](MadeSample& s) {
    if (s.method == 1 && s.joint == 0) s.error_m *= 1.05;
    if (s.method == 1 && s.joint > 0) s.error_m *= 1.5;
    if (s.method == 0 && s.joint == 0) s.error_m *= 1.1;
    if (s.method == 0 && s.take == 3 && s.instant % 5 == 0) s.answered = false;
  });
  const auto alarms = alarms_of(compare(nights));
  ASSERT_GT(alarms.size(), 4u);
  EXPECT_EQ(alarms[0].group, "wrist");
  EXPECT_EQ(alarms[0].method, "nonlinear");
  for (std::size_t k = 1; k < alarms.size(); ++k)
    EXPECT_LE(std::abs(alarms[k].percent), std::abs(alarms[k - 1].percent) + 1e-12);
}

TEST(Gate, AChangeOfHundredthsOfAMillimetreIsNoAlarm) {
  Nights nights;
  const Spoil tiny = [](MadeSample& s) { s.error_m *= 1e-3; };
  write_made_results(nights.folder / "before", {}, tiny);
  write_made_results(nights.folder / "now", {}, [](MadeSample& s) { s.error_m *= 1.5e-3; });
  EXPECT_THAT(alarms_of(compare(nights)), IsEmpty());
}

TEST(Gate, ToleratesLessThanTheSmallestEffectAndToldEffectsCanBeSet) {
  Nights nights;
  nights.write(larger_errors(1.005));
  const Ended ended = nights.gate();
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.out, AllOf(HasSubstr("numbers that changed by less than their limits: "),
                               Not(HasSubstr("errors\n"))));
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
    EXPECT_NEAR(f.percent, -5.0, 1.0);
    EXPECT_LT(f.now, f.before);
  }
  EXPECT_THAT(nights.gate().out, HasSubstr("answers less often"));
}

TEST(Gate, OneTakeThatLostATenthIsEnough) {
  MadeStudy study;
  study.participants = 40;  // of which one is no half percent
  const Nights nights(study, [](MadeSample& s) {
    if (s.method == 1 && s.take == 3 && s.instant % 8 == 0) s.answered = false;
  });
  const auto alarms = alarms_of(compare(nights));
  ASSERT_THAT(alarms, SizeIs(2));  // head and wrist
  EXPECT_EQ(alarms[0].kind, FindingKind::coverage);
  EXPECT_THAT(alarms[0].note, HasSubstr("take p3-walking: "));
  EXPECT_GT(alarms[0].percent, -0.5);
}

TEST(Gate, OneTakeIsJudgedByTheSameRule) {
  MadeStudy study;
  study.participants = 1;
  study.instants = 20;
  const Nights nights(study, larger_errors(1.03));
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

TEST(Gate, NamesSettingsThatDifferAndComparesAllTheSame) {
  Nights nights;
  nights.write(larger_errors(1.1));
  MadeStudy study;
  study.rate_hz = 60.0;
  write_made_results(nights.folder / "before", study);
  const Ended ended = nights.gate();
  EXPECT_EQ(ended.code, 1) << ended.err;
  EXPECT_THAT(ended.out,
              AllOf(HasSubstr("REGRESSION"),
                    HasSubstr("walks, other settings: /study/rate_hz is 30.0 here and 60.0 there")));
}

TEST(Gate, ACalibrationThatDiffersIsASettingAndEveryJointIsJudged) {
  Nights nights;
  nights.write([](MadeSample& s) { s.error_m *= s.joint == 0 ? 0.8 : 1.08; });
  for (const char* side : {"now", "before"}) {
    Json manifest = read_json(nights.folder / side / "manifest.json");
    manifest["inputs"].push_back({{"take", "p0-walking"}, {"role", "calibration"}, {"sha256", side}});
    write_file(nights.folder / side / "manifest.json", manifest.dump());
  }
  const Ended ended = nights.gate();
  EXPECT_EQ(ended.code, 1) << ended.err;
  EXPECT_THAT(ended.out, AllOf(HasSubstr(R"(/takes/p0-walking/calibration is "now" here and "before" there)"),
                               HasSubstr("walking, wrist: +8.0 %"), HasSubstr("walking, head: -20.0 %")));
}

TEST(Gate, AStudyOfAnotherShapeDoesNotBlindTheOthers) {
  ScratchFolder folder;
  MadeStudy other;
  other.name = "runs";
  write_made_results(folder / "now/walks", {}, larger_errors(1.1));
  write_made_results(folder / "before/walks");
  write_made_results(folder / "now/runs", other);
  write_made_results(folder / "before/runs", other);
  Json summary = read_json(folder / "now/runs/summary.json");
  summary["alignments"] = {"rigid"};
  write_file(folder / "now/runs/summary.json", summary.dump());
  const GateReport report = compare_results(folder / "now", folder / "before");
  const auto alarms = alarms_of(report);
  ASSERT_EQ(alarms.size(), 3u);
  EXPECT_EQ(alarms[0].what, "errors are measured in another way");
  EXPECT_EQ(alarms[1].study, "walks");
  EXPECT_NEAR(alarms[1].percent, 10.0, 1e-9);
}

// One study's results take the place of that study's in a baseline of several, whatever their folder is
// called.
TEST(Gate, AcceptingOneStudyKeepsTheOthersOfTheBaseline) {
  const ScratchFolder folder;
  MadeStudy other;
  other.name = "runs";
  write_made_results(folder / "all" / "first", {});
  write_made_results(folder / "all" / "second", other);
  accept_results(folder / "all", folder / "baseline", "first night", "2026-01-01T00:00:00Z");
  write_made_results(folder / "larger", {}, larger_errors(1.1));
  accept_results(folder / "larger", folder / "baseline", "a harder take", "2026-01-02T00:00:00Z");
  const ResultsSet now = find_results(folder / "baseline");
  ASSERT_EQ(now.results.size(), 2u);
  for (const FoundResults& found : now.results) {
    const bool is_walks = found.study == "walks";
    EXPECT_EQ(found.name, is_walks ? "first" : "second");
    EXPECT_EQ(found.summary, read_json(folder / (is_walks ? "larger" : "all/second") / "summary.json"));
  }
}

// Results of a study of clocks, on recordings with that hash, whose median error and share in time are these.
void write_clocks(const std::filesystem::path& folder, double median_s, double share_in_time,
                  const std::vector<std::string>& failed = {}, const std::string& sha256 = "00") {
  MadeStudy study;
  study.name = "runs";
  study.input_sha256 = sha256;
  write_made_results(folder, study);
  Json manifest = read_json(folder / "manifest.json");
  manifest["study"]["kind"] = "clocks";
  write_file(folder / "manifest.json", manifest.dump());
  ClocksSummary summary;
  summary.study = "runs";
  summary.failed = failed;
  summary.numbers.add({{.method = "none", .measure = "clock_error", .statistic = "median"}, median_s});
  summary.numbers.add(
      {{.method = "none", .measure = "clock_error", .statistic = "share_below_2ms"}, share_in_time});
  write_results(folder, summary);
}

// A number of another study that was zero has no size in percent.
TEST(Gate, AMethodThatIsSurelyWorseComesBeforeNumbersThatChanged) {
  ScratchFolder folder;
  for (const char* night : {"now", "before"}) {
    const bool is_now = std::string(night) == "now";
    write_made_results(folder / night / "walks", {}, is_now ? larger_errors(1.1) : Spoil{});
    write_clocks(folder / night / "runs", is_now ? 1.0 : 0.0, 0.5);
  }
  const auto alarms = alarms_of(compare_results(folder / "now", folder / "before"));
  ASSERT_THAT(alarms, SizeIs(3));  // the average of the joints, too
  EXPECT_EQ(alarms[0].study, "walks");
  EXPECT_EQ(alarms[2].study, "runs");
}

TEST(Gate, NumbersOfAnotherKindAreAnAlarmWhereTheyAreWorse) {
  ScratchFolder folder;
  write_clocks(folder / "before", 0.001, 0.5);
  const auto found = [&](double median_s, double share, const std::vector<std::string>& failed = {}) {
    write_clocks(folder / "now", median_s, share, failed);
    return compare_results(folder / "now", folder / "before");
  };
  EXPECT_EQ(found(0.001, 0.5).verdict(), NightVerdict::quiet);
  const GateReport better = found(0.0005, 0.6);
  EXPECT_EQ(better.verdict(), NightVerdict::quiet);
  ASSERT_THAT(better.findings, SizeIs(2));
  for (const GateFinding& f : better.findings) EXPECT_EQ(f.direction, Direction::better) << f.what;
  EXPECT_EQ(found(0.002, 0.5).alarms(), 1u);
  EXPECT_EQ(found(0.001, 0.4).alarms(), 1u);
  EXPECT_EQ(found(0.002, 0.4).alarms(), 2u);
  const auto failed = alarms_of(found(0.001, 0.5, {"walk: is cut"}));
  ASSERT_THAT(failed, SizeIs(1));
  EXPECT_EQ(failed[0].note, "walk: is cut");
  EXPECT_EQ(found(0.001, kNaN).alarms(), 1u);  // a number that is gone
}

TEST(Gate, ASummaryThatWasEditedIsRefusedWithItsPlace) {
  ScratchFolder folder;
  write_clocks(folder / "before", 0.001, 0.5);
  write_clocks(folder / "now", 0.002, 0.5);
  Json summary = read_json(folder / "now/summary.json");
  summary.erase("rows");
  write_file(folder / "now/summary.json", summary.dump());
  EXPECT_THAT(message_of([&] { compare_results(folder / "now", folder / "before"); }),
              AllOf(HasSubstr("now/summary.json"), HasSubstr("rows")));
}

// One number a night has no spread, so other recordings cannot be judged by it.
TEST(Gate, AnotherKindOnOtherRecordingsIsNotJudged) {
  ScratchFolder folder;
  write_clocks(folder / "before", 0.001, 0.5);
  write_clocks(folder / "now", 0.002, 0.4, {}, "11");
  const GateReport report = compare_results(folder / "now", folder / "before");
  EXPECT_EQ(report.verdict(), NightVerdict::not_judged);
  EXPECT_THAT(report.findings, SizeIs(2));
  EXPECT_THAT(gate_summary(report), HasSubstr("NOT JUDGED: other recordings in runs"));
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
                 "walks: is unfinished: 0 of 10 items are there");
  std::filesystem::create_directories(nights.folder / "empty");
  expect_refused(refusal((nights.folder / "empty").string()), "holds no results");
  expect_refused(refusal((nights.folder / "nowhere").string()), "is not a folder");
  Json summary = read_json(nights.folder / "now" / "summary.json");
  Json other = summary;
  other["version"] = 99;
  write_file(nights.folder / "now" / "summary.json", other.dump());
  expect_refused(nights.gate(), "/version: is that of another trilat");
  other = summary;
  other["rows"] = 0;
  write_file(nights.folder / "now" / "summary.json", other.dump());
  expect_refused(nights.gate(), "has no number: nothing was evaluated");
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
  EXPECT_THAT(ended.out, AllOf(HasSubstr("only in the baseline: runs"), HasSubstr("runs: fails")));
  const auto alarms = alarms_of(compare_results(folder / "now", folder / "before"));
  ASSERT_THAT(alarms, SizeIs(1));
  EXPECT_EQ(alarms[0].before, 1.0);
  EXPECT_EQ(alarms[0].now, 0.0);
}

TEST(Gate, AcceptingNeedsAReasonAndIsRemembered) {
  Nights nights;
  nights.write(larger_errors(1.1));
  const std::string history = (nights.folder / "history.csv").string();
  expect_refused(nights.gate({"--accept", " "}), "needs a reason");
  EXPECT_EQ(nights.gate({"--history", history}).code, 1);
  const Ended ended = nights.gate({"--accept", "a <better> model", "--history", history});
  EXPECT_EQ(ended.code, 0) << ended.err;
  const auto accepted = read_json_file<AcceptedBaseline>(nights.before());
  ASSERT_TRUE(accepted.has_value());
  EXPECT_EQ(accepted->reason, "a <better> model");
  EXPECT_THAT(accepted->replaces_sha256, SizeIs(64));
  EXPECT_FALSE(std::filesystem::exists(nights.folder / "before/items"));
  EXPECT_EQ(nights.gate({"--history", history}).code, 0);
  const std::vector<Night> nights_seen = read_history(history);
  ASSERT_THAT(nights_seen, SizeIs(3));
  EXPECT_EQ(nights_seen[0].verdict, NightVerdict::regression);
  EXPECT_THAT(nights_seen[0].alarms, Not(testing::IsEmpty()));
  EXPECT_EQ(nights_seen[1].verdict, NightVerdict::accepted);
  EXPECT_EQ(nights_seen[1].reason, "a <better> model");
  EXPECT_EQ(nights_seen[2].verdict, NightVerdict::quiet);
  EXPECT_EQ(nights_seen[1].mean_error_m, nights_seen[2].mean_error_m);
  EXPECT_THAT(nights_seen[2].mean_error_m, testing::Contains(testing::Key("walks: nonlinear, walking (m)")));
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

}  // namespace
}  // namespace trilat
