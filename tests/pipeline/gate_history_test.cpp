// SPDX-License-Identifier: MIT
#include "datasets/results/gate_history.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "pipeline/gate/night_history.h"
#include "tests/pipeline/made_results.h"
#include "tests/pipeline/program.h"

namespace trilat {
namespace {

using testing::HasSubstr;

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

GateReport report_with(const GateFinding& finding) {
  GateReport report;
  report.time = "night 20";
  report.findings = {finding};
  return report;
}

// Nights 10 to 19, of which those from `first` on raised the alarm about worse_cell().
History alarmed_from(int first) {
  History history;
  for (int n = 10; n < 20; ++n) {
    HistoryEntry entry;
    entry.time = "night " + std::to_string(n);
    if (n >= first) entry.alarms = {"another", key_of(worse_cell())};
    history.entries.push_back(entry);
  }
  return history;
}

TEST(GateHistory, SaysSinceWhenAnAlarmIsRaisedNightByNight) {
  GateReport report = report_with(worse_cell());
  History history = alarmed_from(15);
  EXPECT_EQ(set_since(history, report), 10u);
  EXPECT_EQ(report.findings[0].since, "night 15");
  history.entries[7].alarms.clear();  // a night without it: it began anew
  set_since(history, report);
  EXPECT_EQ(report.findings[0].since, "night 18");
  set_since(alarmed_from(20), report);
  EXPECT_EQ(report.findings[0].since, "night 20");
}

TEST(GateHistory, SaysNothingOfWhatIsNoAlarmOrOfAFirstNight) {
  GateReport report = report_with(worse_cell());
  EXPECT_EQ(set_since({}, report), 0u);
  EXPECT_EQ(report.findings[0].since, "");
  report.findings[0].alarm = false;
  set_since(alarmed_from(15), report);
  EXPECT_EQ(report.findings[0].since, "");
}

TEST(GateHistory, BeginsAnewWithAnAcceptedChange) {
  GateReport report = report_with(worse_cell());
  History history = alarmed_from(10);
  history.entries[6].accepted = true;
  history.entries[6].alarms.clear();
  EXPECT_EQ(set_since(history, report), 4u);
  EXPECT_EQ(report.findings[0].since, "night 17");
}

TEST(GateHistory, LeavesOutWhatWasBeforeTheBaselineWasAccepted) {
  GateReport report = report_with(worse_cell());
  report.baseline_time = "night 15";
  EXPECT_EQ(set_since(alarmed_from(12), report), 5u);
  EXPECT_EQ(report.findings[0].since, "night 15");
}

TEST(GateHistory, ErrorsThatGrowSlowlyAreAnAlarmOnceTheyAddUpAndSaySinceWhen) {
  ScratchFolder folder;
  const std::string now = (folder / "a night").string(), before = (folder / "before").string();
  const std::string history = (folder / "history.jsonl").string();
  const auto night = [&](double factor, std::vector<std::string> more) {
    write_made_results(now, {}, larger_errors(factor));
    std::vector<std::string> arguments{"gate", now, "--baseline", before, "--history", history};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_trilat(folder, arguments);
  };
  ASSERT_EQ(night(1.0, {"--accept", "first"}).code, 0);
  EXPECT_EQ(night(1.004, {}).code, 0);
  EXPECT_EQ(night(1.008, {}).code, 0);
  EXPECT_EQ(night(1.012, {}).code, 1);
  const Ended ended = night(1.016, {});
  EXPECT_EQ(ended.code, 1) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("  since " + read_history(history).entries.at(3).time + "\n"));
  EXPECT_THAT(ended.out, HasSubstr("history: 4 night(s) since the last accepted change\n"));
  EXPECT_THAT(ended.out, HasSubstr("this is meant to be: trilat gate '" + now + "' --baseline "));
  EXPECT_THAT(ended.out, HasSubstr("--history " + history + " --accept \"why\""));
}

TEST(GateHistory, AFileOfAnotherVersionIsRefusedBeforeAnythingIsWritten) {
  ScratchFolder folder;
  write_made_results(folder / "now");
  const std::string now = (folder / "now").string(), before = (folder / "before").string();
  const std::string history = (folder / "history.jsonl").string();
  const std::vector<std::string> accepting{"gate",      now,     "--baseline", before,
                                           "--history", history, "--accept",   "first"};
  ASSERT_EQ(run_trilat(folder, accepting).code, 0);
  std::filesystem::remove_all(before);
  Json line = read_json(history);
  line["version"] = 1;
  write_file(history, line.dump() + "\n");
  expect_refused(run_trilat(folder, accepting),
                 "history.jsonl:1 /version: is another version; this program reads version 2");
  EXPECT_FALSE(std::filesystem::exists(before));
  EXPECT_EQ(read_file(history), line.dump() + "\n");
}

}  // namespace
}  // namespace trilat
