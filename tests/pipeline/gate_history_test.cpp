// SPDX-License-Identifier: MIT
#include "datasets/results/gate_history.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/philox.h"
#include "datasets/results/accepted_baseline.h"
#include "pipeline/gate/judge_history.h"
#include "tests/pipeline/made_results.h"
#include "tests/pipeline/program.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

GateFinding worse_cell() {
  GateFinding f;
  f.kind = FindingKind::accuracy;
  f.alarm = true;
  f.study = "walks";
  f.method = "nonlinear";
  f.condition = "walking";
  f.group = "head";
  return f;
}

HistoryEntry night_of(int number, double error_m) {
  HistoryEntry entry;
  entry.time = "night " + std::to_string(number);
  entry.error_m[series_of("walks", "nonlinear", "walking", "head")] = error_m;
  return entry;
}

TEST(GateHistory, SaysSinceWhenALevelIsWhatItIs) {
  History history;
  for (int n = 1; n <= 10; ++n) history.entries.push_back(night_of(n, n < 7 ? 0.05 : 0.052));
  std::vector<GateFinding> findings{worse_cell()};
  judge_history(history, night_of(11, 0.052), {}, findings);
  EXPECT_EQ(findings[0].since, "night 7");
}

TEST(GateHistory, BeginsAnewWithAnAcceptedChange) {
  History history;
  for (int n = 1; n <= 10; ++n) history.entries.push_back(night_of(n, n < 7 ? 0.05 : 0.052));
  history.entries[6].accepted = true;
  std::vector<GateFinding> none;
  const HistoryJudgement judgement = judge_history(history, night_of(11, 0.052), {}, none);
  EXPECT_EQ(judgement.nights, 4u);
  EXPECT_THAT(judgement.drifts, IsEmpty());
}

TEST(GateHistory, FindsASlowDriftThatNoNightShows) {
  History history;
  for (int n = 1; n <= 15; ++n)
    history.entries.push_back(night_of(n, 0.05 * (n < 6 ? 1.0 : n < 11 ? 1.008 : 1.016)));
  std::vector<GateFinding> none;
  const HistoryJudgement judgement = judge_history(history, night_of(16, 0.05 * 1.016), {}, none);
  ASSERT_THAT(judgement.drifts, SizeIs(1));
  EXPECT_EQ(judgement.drifts[0].since, "night 11");
  EXPECT_NEAR(judgement.drifts[0].percent, 1.6, 1e-6);
  EXPECT_TRUE(judgement.drifts[0].alarm);
}

TEST(GateHistory, FindsAMethodThatAnswersLessAndLess) {
  History history;
  const std::string key = series_of("walks", "nonlinear", "walking", "head");
  for (int n = 1; n <= 15; ++n) {
    history.entries.push_back(night_of(n, 0.05));
    history.entries.back().coverage[key] = n < 6 ? 0.99 : n < 11 ? 0.986 : 0.982;
  }
  HistoryEntry tonight = night_of(16, 0.05);
  tonight.coverage[key] = 0.982;
  std::vector<GateFinding> none;
  const HistoryJudgement judgement = judge_history(history, tonight, {}, none);
  ASSERT_THAT(judgement.drifts, SizeIs(1));
  EXPECT_TRUE(judgement.drifts[0].alarm);
  EXPECT_EQ(judgement.drifts[0].method, "nonlinear");
  EXPECT_EQ(judgement.drifts[0].group, "head");
  EXPECT_EQ(judgement.drifts[0].unit, "");
}

TEST(GateHistory, LeavesOutWhatWasBeforeTheBaselineWasAccepted) {
  History history;
  for (int n = 10; n <= 20; ++n) history.entries.push_back(night_of(n, n < 15 ? 0.05 : 0.052));
  std::vector<GateFinding> none;
  EXPECT_THAT(judge_history(history, night_of(21, 0.052), {}, none).drifts, SizeIs(1));
  const HistoryJudgement judgement = judge_history(history, night_of(21, 0.052), {}, none, "night 15");
  EXPECT_EQ(judgement.nights, 6u);
  EXPECT_THAT(judgement.drifts, IsEmpty());
}

TEST(GateHistory, ADriftIsToldInItsUnitWithIntervalAndCommand) {
  ScratchFolder folder;
  write_made_results(folder / "a night", {}, [](MadeSample& s) { s.error_m = 0.05; });
  const std::string now = (folder / "a night").string(), before = (folder / "before").string();
  const std::string history = (folder / "history.jsonl").string();
  ASSERT_EQ(
      run_trilat(folder, {"gate", now, "--baseline", before, "--accept", "first", "--history", history}).code,
      0);
  Ended ended;
  for (int n = 0; n < 12; ++n) {
    Json summary = read_json(folder / "a night/summary.json");
    summary["cells"][0]["mae_m"] = n < 6 ? 0.05 : 0.0505 + 1e-5 * (n % 2);
    write_file(folder / "a night/summary.json", summary.dump());
    ended = run_trilat(folder,
                       {"gate", now, "--baseline", before, "--history", history, "--smallest-effect", "0.5"});
  }
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.out, HasSubstr("walks, nonlinear: drifted, worse\n  walking, head: +"));
  EXPECT_THAT(ended.out, HasSubstr(" to "));
  EXPECT_THAT(ended.out, HasSubstr("cm"));
  EXPECT_THAT(ended.out, HasSubstr("see: trilat gate '"));
  EXPECT_THAT(ended.out, HasSubstr("a night' --baseline "));
  EXPECT_THAT(ended.out, HasSubstr("--history " + history + " --accept \"why\""));
}

TEST(GateHistory, ALineIsAddedOnlyWhenAllElseIsWritten) {
  ScratchFolder folder;
  write_made_results(folder / "now");
  write_made_results(folder / "before");
  const std::string history = (folder / "history.jsonl").string();
  expect_refused(
      run_trilat(folder, {"gate", (folder / "now").string(), "--baseline", (folder / "before").string(),
                          "--history", history, "--junit", (folder / "no/such/folder/gate.xml").string()}),
      "gate.xml");
  EXPECT_FALSE(std::filesystem::exists(history));
}

}  // namespace
}  // namespace trilat
