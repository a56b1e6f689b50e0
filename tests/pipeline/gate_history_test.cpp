// SPDX-License-Identifier: MIT
#include "datasets/results/gate_history.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "pipeline/gate/gate_report.h"
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
std::vector<Night> alarmed_from(int first) {
  std::vector<Night> history;
  for (int n = 10; n < 20; ++n) {
    Night night{.time = "night " + std::to_string(n), .program = "0.5.0"};
    if (n >= first) night.alarms = {"another", key_of(worse_cell())};
    history.push_back(night);
  }
  return history;
}

TEST(GateHistory, SaysSinceWhenAnAlarmIsRaisedNightByNight) {
  GateReport report = report_with(worse_cell());
  std::vector<Night> history = alarmed_from(15);
  EXPECT_EQ(set_since(history, report), 10u);
  EXPECT_EQ(report.findings[0].since, "night 15");
  history[7].alarms.clear();  // a night without it: it began anew
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
  std::vector<Night> history = alarmed_from(10);
  history[6].verdict = NightVerdict::accepted;
  history[6].alarms.clear();
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
  const std::string history = (folder / "history.csv").string();
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
  EXPECT_THAT(ended.out, HasSubstr("  since " + read_history(history).at(3).time + "\n"));
  EXPECT_THAT(ended.out, HasSubstr("history: 4 night(s) since the last accepted change\n"));
  EXPECT_THAT(ended.out, HasSubstr("this is meant to be: trilat gate '" + now + "' --baseline "));
  EXPECT_THAT(ended.out, HasSubstr("--history " + history + " --accept \"why\""));
}

TEST(GateHistory, IsReadBackAsItWasWrittenWithAColumnForEachMeanError) {
  ScratchFolder folder;
  const auto history = folder / "history.csv";
  add_to_history(history, {.time = "2026-01-01T03:00:00Z",
                           .program = "0.5.0",
                           .verdict = NightVerdict::accepted,
                           .reason = "lag, \"modelled\"",
                           .mean_error_m = {{"walks: rts, walking (m)", 0.04}}});
  add_to_history(history, {.time = "2026-01-02T03:00:00Z",
                           .program = "0.5.0",
                           .verdict = NightVerdict::regression,
                           .alarms = {"one, of two", "another"},
                           .not_judged = {"walks"},
                           .mean_error_m = {{"walks: mean, walking (m)", 0.1 + 0.2}}});
  const std::string text = read_file(history);
  EXPECT_THAT(text,
              testing::StartsWith("time,program,verdict,reason,alarms,not_judged,\"walks: mean, walking "
                                  "(m)\",\"walks: rts, walking (m)\"\n"));
  EXPECT_EQ(std::ranges::count(text, '\n'), 3);
  const std::vector<Night> nights = read_history(history);
  ASSERT_EQ(nights.size(), 2u);
  EXPECT_EQ(nights[0].time, "2026-01-01T03:00:00Z");
  EXPECT_EQ(nights[0].program, "0.5.0");
  EXPECT_EQ(nights[0].verdict, NightVerdict::accepted);
  EXPECT_EQ(nights[0].reason, "lag, \"modelled\"");
  EXPECT_THAT(nights[0].alarms, testing::IsEmpty());
  EXPECT_THAT(nights[0].mean_error_m, testing::ElementsAre(std::pair{"walks: rts, walking (m)", 0.04}));
  EXPECT_EQ(nights[1].verdict, NightVerdict::regression);
  EXPECT_THAT(nights[1].alarms, testing::ElementsAre("one, of two", "another"));
  EXPECT_THAT(nights[1].not_judged, testing::ElementsAre("walks"));
  EXPECT_THAT(nights[1].mean_error_m, testing::ElementsAre(std::pair{"walks: mean, walking (m)", 0.1 + 0.2}));
}

TEST(GateHistory, WhatASpreadsheetSavedIsReadToo) {
  ScratchFolder folder;
  const auto history = folder / "history.csv";
  write_file(history, std::string(kHistoryHeader) + ",a (m)\r\n2026,0.5.0,quiet,,,,0.5\r\n");
  const std::vector<Night> nights = read_history(history);
  ASSERT_EQ(nights.size(), 1u);
  EXPECT_THAT(nights[0].mean_error_m, testing::ElementsAre(std::pair{"a (m)", 0.5}));
}

TEST(GateHistory, NamesOfAlarmsStayWholeWhateverTheMethodsAreCalled) {
  ScratchFolder folder;
  GateFinding finding = worse_cell();
  finding.method = "rts; sigma 2";
  add_to_history(folder / "history.csv",
                 {.time = "night 19", .program = "0.5.0", .alarms = {key_of(finding)}});
  GateReport report = report_with(finding);
  set_since(read_history(folder / "history.csv"), report);
  EXPECT_EQ(report.findings[0].since, "night 19");
}

TEST(GateHistory, WhatCannotBeReadIsRefusedBeforeAnythingIsWritten) {
  ScratchFolder folder;
  write_made_results(folder / "now");
  const auto before = folder / "before", history = folder / "history.csv";
  const std::string header = std::string(kHistoryHeader) + ",a (m)\n";
  const std::vector<std::pair<std::string, std::string>> bad{
      {R"({"format":"trilat.history","version":2})"
       "\n",
       "history.csv:1: is a history of version 0.4.0; move it"},
      {header + "2026,0.5.0,quiet,,,,0.5\n2026,0.5.0,qui\n",
       "history.csv:3: has 3 of 7 cells: the line is cut"},
      {header + "2026,0.5.0,quiet,,,,0.5\n2026,0.5.0,quiet,,,,0.0",
       "history.csv:3: is cut: the line has no end"},
      {header + "2026,0.5.0,fine,,,,0.5\n", "history.csv:2: verdict is \"fine\"; it must be one of quiet, "},
      {header + "2026,0.5.0,quiet,,,,-0.5\n",
       "history.csv:2: a (m) is \"-0.5\"; it must be an error in metres"},
      {header + "2026,0.5.0,quiet,,,,5 cm\n",
       "history.csv:2: a (m) is \"5 cm\"; it must be an error in metres"},
      {std::string(kHistoryHeader) + "s\n", "history.csv:1: must begin with \"time,program,verdict,"}};
  for (const auto& [text, message] : bad) {
    write_file(history, text);
    const Ended ended = run_trilat(folder, {"gate", (folder / "now").string(), "--baseline", before.string(),
                                            "--history", history.string(), "--accept", "first"});
    expect_refused(ended, message);
    EXPECT_FALSE(std::filesystem::exists(before)) << message;
    EXPECT_EQ(read_file(history), text);
  }
  write_file(history, "time,temperature\n1,2\n");
  expect_refused(run_trilat(folder, {"gate", (folder / "now").string(), "--baseline", before.string(),
                                     "--history", history.string(), "--accept", "first"}),
                 "history.csv");
}

}  // namespace
}  // namespace trilat
