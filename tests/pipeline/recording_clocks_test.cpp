// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <gmock/gmock.h>

#include "pipeline/recording/clock_errors.h"
#include "pipeline/recording/clock_methods.h"
#include "pipeline/recording/processing_time.h"

namespace trilat {
namespace {

using testing::Each;

RecordingSpec spec_of(std::uint64_t frames, std::optional<double> jitter_back_s = {}) {
  RecordingSpec spec;
  spec.frames = frames;
  spec.networks[0].jitter_back_s = jitter_back_s;
  return spec;
}

// One in each range, on their lower edges, and one that is no number.
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
  return trial;
}

TEST(ClockMethods, TheErrorsOfAnExchangeByPencil) {
  const ClockTrial trial = pencil_trial();
  const auto second_ms = [&](ClockMethod method) { return 1e3 * clock_errors_s(trial, method)[1]; };
  EXPECT_NEAR(second_ms(ClockMethod::none), 10.0, 1e-9);
  EXPECT_NEAR(second_ms(ClockMethod::first_exchange), 0.0, 1e-9);
  EXPECT_NEAR(second_ms(ClockMethod::corrected), 0.0, 1e-9);
  // D = 1 ms, E = -10 ms: 202 - 1 + 10 = 211 ms, where 210 is the client's time and 200 the server's
  EXPECT_NEAR(second_ms(ClockMethod::printed_client), 1.0, 1e-9);
  EXPECT_NEAR(second_ms(ClockMethod::printed), 11.0, 1e-9);
}

TEST(ClockMethods, BeforeAnyExchangeThePrintedOnesHaveNoAnswer) {
  const ClockTrial trial = pencil_trial();
  EXPECT_TRUE(std::isnan(clock_errors_s(trial, ClockMethod::printed)[0]));
  EXPECT_TRUE(std::isnan(clock_errors_s(trial, ClockMethod::printed_client)[0]));
  ClockTrial silent = trial;
  silent.exchanges.clear();
  for (std::size_t m = 1; m < clock_method_names().size(); ++m)
    EXPECT_TRUE(std::isnan(clock_errors_s(silent, static_cast<ClockMethod>(m))[1])) << m;
}

// A client 10 ms ahead, asked every 100 ms. Exchange 0 takes 1 ms each way; the others 1 ms back but 1 + k ms
// there, so that by them the client seems to be k / 2 ms further ahead. Frames are sent as soon as they are
// made and take 1 ms.
ClockTrial slower_and_slower(std::int64_t exchanges, const std::vector<std::int64_t>& frames_ms) {
  constexpr std::int64_t kMs = 1'000'000;
  ClockTrial trial;
  for (std::int64_t k = 0; k < exchanges; ++k) {
    const std::int64_t t1 = 100 * k, t2 = t1 + 1 + k;
    trial.exchanges.push_back({t1 * kMs, (t2 + 10) * kMs, (t2 + 10) * kMs, (t2 + 1) * kMs});
  }
  for (std::int64_t at : frames_ms)
    trial.frames.push_back({{0, 0, (at + 10) * kMs}, {at * kMs}, {at * kMs}, {(at + 1) * kMs}});
  return trial;
}

TEST(ClockMethods, TheCausalOneTakesTheLeastDelayOfTheLastEightExchangesThatTheServerHas) {
  // Answers come at 2, 103, 204, …; at 1 none has come, at 710 eight have, and from 810 on the first is too
  // old.
  const auto errors_s =
      clock_errors_s(slower_and_slower(10, {0, 50, 150, 709, 811, 950}), ClockMethod::corrected_causal);
  EXPECT_TRUE(std::isnan(errors_s[0]));
  EXPECT_NEAR(errors_s[1], 0.0, 1e-12);
  EXPECT_NEAR(errors_s[2], 0.0, 1e-12);
  EXPECT_NEAR(errors_s[3], 0.0, 1e-12);
  EXPECT_NEAR(errors_s[4], -0.0005, 1e-12);
  EXPECT_NEAR(errors_s[5], -0.001, 1e-12);
}

TEST(ClockMethods, TheCausalOneDoesNotChangeByWhatComesLater) {
  const RecordingSpec spec = spec_of(300);
  ClockTrial trial = simulate_clocks(spec, {}, 0, 1);
  const auto all_s = clock_errors_s(trial, ClockMethod::corrected_causal);
  std::erase_if(trial.exchanges,
                [&](const ClockExchange& e) { return e.t4_ns > trial.frames[150].received.ns; });
  trial.frames.resize(151);
  const auto first_s = clock_errors_s(trial, ClockMethod::corrected_causal);
  for (std::size_t f = 1; f < first_s.size(); ++f) EXPECT_EQ(first_s[f], all_s[f]) << f;
  EXPECT_NE(clock_errors_s(trial, ClockMethod::corrected)[100], 0.0);
}

TEST(ClockTrial, NetworksAreComparedOnTheSameDraws) {
  const RecordingSpec spec = spec_of(60);
  NetworkSpec other;
  other.asymmetry_s = 0.002;
  const ClockTrial a = simulate_clocks(spec, {}, 0, 1), b = simulate_clocks(spec, other, 0, 1);
  ASSERT_EQ(a.exchanges.size(), b.exchanges.size());
  EXPECT_NEAR(static_cast<double>(b.exchanges[3].t2_ns - a.exchanges[3].t2_ns), 2e6, 200.0);
  EXPECT_EQ(a.frames[10].stamp.arrival_ns, b.frames[10].stamp.arrival_ns);
  EXPECT_NE(a.frames[10].stamp.arrival_ns, simulate_clocks(spec, {}, 1, 1).frames[10].stamp.arrival_ns);
}

TEST(ClockTrial, ALoadedWayBackLeavesTheWayThereAlone) {
  const RecordingSpec spec = spec_of(60, 0.02);
  const ClockTrial a = simulate_clocks(spec, {}, 0, 1), b = simulate_clocks(spec, spec.networks[0], 0, 1);
  double there_ns = 0.0, back_ns = 0.0;
  for (std::size_t i = 0; i < a.exchanges.size(); ++i) {
    there_ns = std::max(there_ns, std::abs(static_cast<double>(b.exchanges[i].t2_ns - a.exchanges[i].t2_ns)));
    back_ns = std::max(back_ns, static_cast<double>(b.exchanges[i].t4_ns - a.exchanges[i].t4_ns));
  }
  EXPECT_EQ(there_ns, 0.0);
  EXPECT_GT(back_ns, 1e7);
}

TEST(ClockTrial, ASensorExposesAtTheRateOfItsOwnClock) {
  const RecordingSpec spec = spec_of(18000);
  double slowest_s = 0.0;
  for (std::uint64_t sensor = 0; sensor < 4; ++sensor) {
    const ClockTrial trial = simulate_clocks(spec, {}, 0, sensor);
    const TrialFrame &first = trial.frames.front(), &last = trial.frames.back();
    const double by_sensor_s =
        1e-9 *
        static_cast<double>((last.stamp.device_ticks - first.stamp.device_ticks) * trial.sensor.tick_ns);
    const double by_server_s = 1e-9 * static_cast<double>(last.exposure.ns - first.exposure.ns);
    EXPECT_NEAR(by_sensor_s, 17999.0 / 30.0, 2e-6);
    EXPECT_NEAR(by_server_s, 17999.0 / 30.0, 1.001 * 30e-6 * 600.0);
    slowest_s = std::max(slowest_s, std::abs(by_server_s - 17999.0 / 30.0));
  }
  EXPECT_GT(slowest_s, 0.001);
}

TEST(ClockTrial, ALateFrameHoldsUpThoseBehindIt) {
  const RecordingSpec spec = spec_of(300, 0.2);
  const ClockTrial trial = simulate_clocks(spec, spec.networks[0], 0, 1);
  std::size_t held_up = 0;
  for (std::size_t f = 1; f < trial.frames.size(); ++f) {
    EXPECT_GE(trial.frames[f].received.ns, trial.frames[f - 1].received.ns) << f;
    held_up += trial.frames[f].received == trial.frames[f - 1].received;
  }
  EXPECT_GT(held_up, 100u);
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
