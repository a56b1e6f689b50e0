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

Numbers numbers_of(const std::vector<std::vector<double>>& units_s) {
  std::vector<UnitErrors> units;
  for (const std::vector<double>& errors_s : units_s)
    units.push_back({"walk", "k" + std::to_string(units.size() + 1), errors_s});
  Numbers numbers;
  add_clock_errors("none", units, numbers);
  return numbers;
}

double number_in(const Numbers& numbers, const char* statistic, const NumberKey& more = {}) {
  return numbers.value(
      NumberKey{.method = "none", .measure = "clock_error", .statistic = statistic}.with(more));
}

// One error on the lower edge of each range, and one that is not known: ranges begin on their edges.
TEST(ClockErrors, RangesBeginOnTheirEdges) {
  const Numbers edges = numbers_of({{0.0, -0.002, 0.004, 0.011, -0.022, 0.033, kNaN, kNaN}});
  for (const TimeRange& range : kTimeRanges) EXPECT_EQ(number_in(edges, range.share), 0.125) << range.share;
  EXPECT_EQ(number_in(edges, kShareBelow4ms), 0.25);
  const Numbers inside = numbers_of({{0.0019999, 0.0329999, -5.0, 0.0039999}});
  EXPECT_EQ(number_in(inside, "share_below_2ms"), 0.25);
  EXPECT_EQ(number_in(inside, "share_from_2_to_4ms"), 0.25);
  EXPECT_EQ(number_in(inside, "share_from_22_to_33ms"), 0.25);
  EXPECT_EQ(number_in(inside, "share_from_33ms"), 0.25);
}

// 0 to 1000 ms in steps of one: quantiles are the numbers themselves.
TEST(ClockErrors, QuantilesByPencil) {
  std::vector<double> errors_s;
  for (int i = 1000; i >= 0; --i) errors_s.push_back((i % 2 ? -1e-3 : 1e-3) * i);
  const Numbers numbers = numbers_of({errors_s});
  EXPECT_NEAR(number_in(numbers, "median"), 0.5, 1e-12);
  EXPECT_NEAR(number_in(numbers, "p95"), 0.95, 1e-12);
  EXPECT_NEAR(number_in(numbers, "p99"), 0.99, 1e-12);
  EXPECT_NEAR(number_in(numbers, "p999"), 0.999, 1e-12);
  EXPECT_NEAR(number_in(numbers, "max"), 1.0, 1e-12);
  EXPECT_TRUE(numbers_of({{kNaN}}).all().empty());
}

// Two computers, one of which is always below 4 ms; the interval is over them.
TEST(ClockErrors, SharesOfEachComputerAndOfAllByPencil) {
  const Numbers numbers = numbers_of({{0.001, 0.003, 0.003, 0.003}, {0.001, 0.001, 0.005, kNaN}});
  EXPECT_EQ(number_in(numbers, "share_below_2ms", {.group = "k1", .take = "walk"}), 0.25);
  EXPECT_EQ(number_in(numbers, "share_below_2ms", {.group = "k2", .take = "walk"}), 0.5);
  EXPECT_EQ(number_in(numbers, kShareBelow4ms, {.group = "k2", .take = "walk"}), 0.5);
  EXPECT_EQ(number_in(numbers, "share_below_2ms"), 0.375);
  EXPECT_EQ(number_in(numbers, kShareBelow4ms), 0.75);
  EXPECT_EQ(number_in(numbers, "share_of_units_below_4ms"), 0.5);
  const Number* all =
      numbers.find({.method = "none", .measure = "clock_error", .statistic = "share_below_2ms"});
  EXPECT_EQ(all->n, 8u);
  EXPECT_EQ(all->clusters, 2u);
  EXPECT_LT(all->low, 0.25);
  EXPECT_GT(all->high, 0.5);
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
  const double none = kNaN;
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
