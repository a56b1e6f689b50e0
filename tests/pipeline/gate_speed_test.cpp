// SPDX-License-Identifier: MIT
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include "pipeline/gate/judge_speed.h"
#include "pipeline/gate/measure_speed.h"
#include "pipeline/gate/other_work.h"
#include "tests/pipeline/made_results.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/simulated_speed.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// The nights that raise an alarm, and those that raise one about nonlinear.
std::pair<int, int> alarms_in(int nights, double slower) {
  std::pair<int, int> alarms;
  for (int n = 0; n < nights; ++n) {
    const auto night = static_cast<std::uint64_t>(n) * 8;
    std::uint64_t rerun = 2;
    const auto findings =
        judge_speed(measured_speed_night(night, slower), measured_speed_baseline(night + 1), {}, [&] {
          return measured_speed_night(night + rerun++, slower);
        }).findings;
    alarms.first +=
        std::any_of(findings.begin(), findings.end(), [](const GateFinding& f) { return f.alarm; });
    alarms.second += std::any_of(findings.begin(), findings.end(),
                                 [](const GateFinding& f) { return f.alarm && f.method == "nonlinear"; });
  }
  return alarms;
}

int nights_asked(int few, int most) {
  const char* more = std::getenv("TRILAT_NIGHTS");
  return more ? std::clamp(std::atoi(more), few, most) : few;
}

TEST(GateSpeed, NullNightsAlarmInOneOfAHundredAtMost) {
  const int nights = nights_asked(10, 1000);
  const int alarms = alarms_in(nights, 0.0).first;
  std::printf("speed: %d alarms in %d simulated nights\n", alarms, nights);
  EXPECT_LE(alarms, nights / 100);
}

TEST(GateSpeed, ATenPercentSlowerSolverIsFound) {
  const int nights = nights_asked(10, 200);
  const int found = alarms_in(nights, 0.10).second;
  std::printf("speed: 10 %% found in %d of %d simulated nights\n", found, nights);
  EXPECT_GE(10 * found, 9 * nights);
}

TEST(GateSpeed, WithoutConfirmationThereIsNoAlarm) {
  const auto refuted = judge_speed(measured_speed_night(1, 0.3, 0.3), measured_speed_night(2, 0.0, 0.3), {},
                                   [] { return measured_speed_night(3, 0.0, 0.3); });
  ASSERT_THAT(refuted.findings, SizeIs(1));
  EXPECT_FALSE(refuted.findings[0].alarm);
  EXPECT_THAT(refuted.findings[0].note, HasSubstr("not confirmed"));
  EXPECT_TRUE(refuted.verdict.rerun);
  const auto alone =
      judge_speed(measured_speed_night(1, 0.3, 0.3), measured_speed_night(2, 0.0, 0.3), {}, {});
  ASSERT_THAT(alone.findings, SizeIs(1));
  EXPECT_FALSE(alone.findings[0].alarm);
  EXPECT_FALSE(alone.verdict.rerun);
}

TEST(GateSpeed, WhatIsMeasuredBesideOtherWorkIsToldAndNoAlarm) {
  SpeedFile busy = measured_speed_night(1, 0.3, 0.3);
  busy.others_busy = 1.5;
  const SpeedFile baseline = measured_speed_night(2, 0.0, 0.3);
  const auto again = [] { return measured_speed_night(3, 0.3, 0.3); };
  const auto judged = judge_speed(busy, baseline, {}, again);
  ASSERT_THAT(judged.findings, SizeIs(1));
  EXPECT_FALSE(judged.findings[0].alarm);
  EXPECT_THAT(judged.verdict.note, HasSubstr("other programs kept 1.5 processors busy"));
  const auto disturbed_again =
      judge_speed(measured_speed_night(1, 0.3, 0.3), baseline, {}, [&] { return busy; });
  EXPECT_FALSE(disturbed_again.findings.at(0).alarm);
  EXPECT_TRUE(judge_speed(measured_speed_night(1, 0.3, 0.3), baseline, {}, again).findings.at(0).alarm);
}

TEST(GateSpeed, SeesThatAnotherProcessWorks) {
  const OtherWork others;
  const pid_t child = fork();
  if (child == 0)
    for (std::atomic<unsigned> counted = 0;;) ++counted;
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  EXPECT_GT(others.processors(), 0.05);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

TEST(GateSpeed, AFasterSolverIsToldAndNeedsNoRerun) {
  const auto judged =
      judge_speed(measured_speed_night(1, -0.3, 0.3), measured_speed_night(2, 0.0, 0.3), {}, [] {
        ADD_FAILURE();
        return measured_speed_night(3);
      });
  ASSERT_THAT(judged.findings, SizeIs(1));
  EXPECT_EQ(judged.findings[0].direction, Direction::better);
  EXPECT_FALSE(judged.findings[0].alarm);
}

TEST(GateSpeed, IsNotJudgedOnAnotherProcessorOrAgainstAnotherReference) {
  SpeedFile other = measured_speed_night(2);
  other.processor = "another";
  EXPECT_THAT(judge_speed(measured_speed_night(1, 0.5), other, {}, {}).findings, IsEmpty());
  EXPECT_THAT(judge_speed(measured_speed_night(1), other, {}, {}).verdict.note,
              HasSubstr("the baseline's \"another\""));
  other = measured_speed_night(2);
  other.reference = "version 2";
  EXPECT_FALSE(judge_speed(measured_speed_night(1), other, {}, {}).verdict.judged);
}

TEST(GateSpeed, SeveralMeasurementsBecomeOne) {
  const SpeedFile a = measured_speed_night(1), b = measured_speed_night(2);
  const SpeedFile joined = joined_speed({a, b});
  ASSERT_THAT(joined.solvers, SizeIs(a.solvers.size()));
  ASSERT_THAT(joined.solvers[3].ratios, SizeIs(960));
  EXPECT_EQ(joined.solvers[3].ratios[0], a.solvers[3].ratios[0]);
  EXPECT_EQ(joined.solvers[3].ratios[480], b.solvers[3].ratios[0]);
}

TEST(GateSpeed, MeasuresEverySolverInEveryRoundAndTheFileKeepsIt) {
  ScratchFolder folder;
  const SpeedFile speed = measure_speed({3, 16, 0.0, {}, {}});
  ASSERT_THAT(speed.solvers, SizeIs(7));
  for (const SolverSpeed& s : speed.solvers) {
    EXPECT_THAT(s.ratios, SizeIs(3));
    EXPECT_GT(s.median_ns, 0.0);
  }
  write_speed(folder.path(), speed);
  const auto read = read_speed(folder.path());
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->solvers[6].ratios, speed.solvers[6].ratios);
  EXPECT_EQ(read->processor, speed.processor);
  Json broken = read_json(folder / "speed.json");
  broken["solvers"][1]["ratios"][0] = -1.0;
  write_file(folder / "speed.json", broken.dump());
  EXPECT_THAT(message_of([&] { read_speed(folder.path()); }),
              HasSubstr("/solvers/1/ratios: must hold positive"));
}

TEST(GateSpeed, ASlowDriftOverTheNightsIsTold) {
  ScratchFolder folder;
  write_made_results(folder / "now");
  const std::string now = (folder / "now").string(), before = (folder / "before").string();
  const std::string history = (folder / "history.jsonl").string();
  write_speed(folder / "now", measured_speed_night(1, 0.0, 0.5));
  ASSERT_EQ(
      run_trilat(folder, {"gate", now, "--baseline", before, "--accept", "first", "--history", history}).code,
      0);
  Ended ended;
  for (std::uint64_t n = 0; n < 12; ++n) {
    write_speed(folder / "now", measured_speed_night(2 + n, n < 6 ? 0.0 : 0.04, 0.5));
    ended = run_trilat(folder, {"gate", now, "--baseline", before, "--history", history});
  }
  EXPECT_EQ(ended.code, 1) << ended.out;
  EXPECT_THAT(ended.out, HasSubstr("nonlinear: drifted, worse"));
}

}  // namespace
}  // namespace trilat
