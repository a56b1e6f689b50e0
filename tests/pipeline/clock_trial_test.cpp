// SPDX-License-Identifier: MIT
#include "pipeline/clocks/clock_trial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/clocks/clocks_study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::Each;

// One time on the lower edge of each range, and a NaN.
TEST(SpreadTimes, RangesBeginOnTheirEdges) {
  const TimeSpread spread =
      spread_times({0.0, 0.002, 0.004, 0.011, 0.022, 0.033, std::numeric_limits<double>::quiet_NaN()});
  EXPECT_EQ(spread.n, 6u);
  EXPECT_THAT(spread.bins, Each(1u));
  EXPECT_EQ(spread_times({0.0019999, 0.0329999, 5.0}).bins, (TimeSpread{3, {1, 0, 0, 0, 1, 1}}.bins));
}

// 0 to 1000 ms in steps of one: quantiles are the numbers themselves.
TEST(SpreadTimes, QuantilesByPencil) {
  std::vector<double> times_s;
  for (int i = 1000; i >= 0; --i) times_s.push_back(1e-3 * i);
  const TimeSpread spread = spread_times(times_s);
  EXPECT_NEAR(spread.median_s, 0.5, 1e-12);
  EXPECT_NEAR(spread.p95_s, 0.95, 1e-12);
  EXPECT_NEAR(spread.p99_s, 0.99, 1e-12);
  EXPECT_NEAR(spread.p999_s, 0.999, 1e-12);
  EXPECT_NEAR(spread.max_s, 1.0, 1e-12);
  EXPECT_TRUE(std::isnan(spread_times({}).median_s));
}

// A client 10 ms ahead; a message takes 1 ms there and back; one frame, 2 ms on its way.
ClockTrial pencil_trial() {
  constexpr std::int64_t kMs = 1'000'000;
  ClockTrial trial;
  trial.exchanges = {{100 * kMs, 111 * kMs, 112 * kMs, 103 * kMs}};
  trial.frames = {{{0, 0, 60 * kMs}, {30 * kMs}, {50 * kMs}, {52 * kMs}},
                  {{1, 0, 210 * kMs}, {180 * kMs}, {200 * kMs}, {202 * kMs}}};
  trial.clock.agent = fit_agent_clock(trial.exchanges);
  trial.is_exact = true;
  return trial;
}

TEST(ClockMethods, TheErrorsOfAnExchangeByPencil) {
  const ClockTrial trial = pencil_trial();
  const auto second_ms = [&](ClockMethod method) { return 1e3 * clock_errors_s(trial, method)[1]; };
  EXPECT_NEAR(second_ms(ClockMethod::none), 10.0, 1e-9);
  EXPECT_NEAR(second_ms(ClockMethod::first_exchange), 0.0, 1e-9);
  EXPECT_NEAR(second_ms(ClockMethod::offline), 0.0, 1e-9);
  EXPECT_NEAR(second_ms(ClockMethod::causal), 0.0, 1e-9);
  // D = 1 ms, E = -10 ms: 202 - 1 + 10 = 211 ms, where 210 is the client's time and 200 the server's
  EXPECT_NEAR(second_ms(ClockMethod::printed_client), 1.0, 1e-9);
  EXPECT_NEAR(second_ms(ClockMethod::printed), 11.0, 1e-9);
}

TEST(ClockMethods, BeforeAnyExchangeThePrintedOnesHaveNoAnswer) {
  const ClockTrial trial = pencil_trial();
  EXPECT_TRUE(std::isnan(clock_errors_s(trial, ClockMethod::printed)[0]));
  EXPECT_TRUE(std::isnan(clock_errors_s(trial, ClockMethod::printed_client)[0]));
}

TEST(ClockMethods, TheOfflineFitThatIsItselfTheTruthHasNoError) {
  ClockTrial trial = pencil_trial();
  trial.is_exact = false;
  for (const ClockMethod method : {ClockMethod::offline, ClockMethod::ticks})
    EXPECT_TRUE(std::isnan(clock_errors_s(trial, method)[1]));
  EXPECT_NEAR(clock_errors_s(trial, ClockMethod::none)[1], 0.01, 1e-12);
}

// Its sensors are free running, so that each has a clock of its own, up to 1000 s away.
TEST(ClockTrial, OfASimulatedRecordingHasTheSimulatorsTimes) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "c", walking_spec(1, 12.0));
  const SessionReader session(campaign.takes[0].session);
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    const ClockTrial trial = read_clock_trial(session, s);
    EXPECT_TRUE(trial.is_exact);
    EXPECT_EQ(trial.frames.size(), session.counts(s).body_frames);
    for (const double error_s : clock_errors_s(trial, ClockMethod::offline))
      EXPECT_LT(std::abs(error_s), 5e-4);
    for (const double error_s : clock_errors_s(trial, ClockMethod::ticks)) EXPECT_LT(std::abs(error_s), 5e-4);
    for (const double error_s : clock_errors_s(trial, ClockMethod::causal))
      EXPECT_LT(std::abs(error_s), 3e-3);
    EXPECT_GT(std::abs(clock_errors_s(trial, ClockMethod::none)[0]), 1.0);
    HostTime before;
    for (const TrialFrame& f : trial.frames) {
      EXPECT_GE((f.sent - f.exposure).seconds(), 0.02);
      EXPECT_GE((f.received - f.sent).seconds(), 0.0002 - 1e-9);  // the wire
      EXPECT_GE(f.received, before);
      before = f.received;
    }
  }
  // without what the simulator knows, the offline fit stands for it
  std::filesystem::remove(folder / "c/p01-walking/truth.json");
  const ClockTrial fitted = read_clock_trial(session, 0);
  EXPECT_FALSE(fitted.is_exact);
  EXPECT_EQ(fitted.frames[5].sent, fitted.clock.agent({fitted.frames[5].stamp.arrival_ns}));
}

struct QueuePencil {
  std::vector<TrialFrame> frames;
  std::vector<double> errors_s;
};

QueuePencil pencil_queue() {
  constexpr std::int64_t kMs = 1'000'000;
  const double none = std::numeric_limits<double>::quiet_NaN();
  QueuePencil pencil;
  const auto add = [&](std::int64_t sent, std::int64_t received, double error_s) {
    pencil.frames.push_back({{}, {}, {sent * kMs}, {received * kMs}});
    pencil.errors_s.push_back(error_s);
  };
  add(10, 12, 0.0);
  add(40, 61, 0.0);  // the server's frame at 60 began while it was on its way
  add(70, 72, 0.0);
  add(85, 86, 0.0);  // the frame at 90 is that of the one before
  add(100, 101, 0.0);
  add(130, 131, 0.1);  // seems to come from the future
  add(140, 141, none);
  add(150, 180, 0.0);  // just as old as is allowed
  return pencil;
}

TEST(FrameQueue, AServerWithFramesOfItsOwnDropsWhatIsOlderThanAFrameByPencil) {
  const auto [frames, errors_s] = pencil_queue();
  const Duration ms30 = duration_from_s(0.03);
  EXPECT_EQ(run_queue(frames, errors_s, {ms30, ms30}), (QueueCounts{8, 1, 1, 2, 4}));
}

TEST(FrameQueue, TakenAsTheyComeFramesAreAsOldAsTheirDelay) {
  const auto [frames, errors_s] = pencil_queue();
  EXPECT_EQ(run_queue(frames, errors_s, {duration_from_s(0.03), {0}}), (QueueCounts{8, 1, 1, 0, 6}));
  EXPECT_EQ(run_queue(frames, errors_s, {duration_from_s(0.02), {0}}), (QueueCounts{8, 1, 1, 2, 4}));
}

}  // namespace
}  // namespace trilat
