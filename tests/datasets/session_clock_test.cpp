// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "datasets/base/error.h"
#include "datasets/session/clock/agent_clock.h"
#include "tests/datasets/simulated_clocks.h"

namespace trilat {
namespace {

// The number to reach: 99.9 % of frames within 1 ms and all within 2 ms.
void expect_within_a_millisecond(const SimulatedClocks& clocks) {
  const ClockErrors errors = clock_errors(clocks);
  EXPECT_GE(errors.share_within(1.0), 0.999) << "seed " << clocks.seed;
  EXPECT_LE(errors.max_ms(), 2.0) << "seed " << clocks.seed;
}

TEST(SensorClock, TenMinutesOfJitterAndDriftLeaveFramesWithinAMillisecond) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) expect_within_a_millisecond({.seed = seed});
}

TEST(SensorClock, LostExchangesAndFramesDoNoHarm) {
  expect_within_a_millisecond({.lost_share = 0.05});
  expect_within_a_millisecond({.lost_share = 0.5});
}

TEST(SensorClock, BurstsOfDelayAreLeftOut) {
  expect_within_a_millisecond({.burst_every_s = 60.0, .burst_length_s = 5.0, .burst_ms = 50.0});
  expect_within_a_millisecond({.burst_every_s = 120.0, .burst_length_s = 40.0, .burst_ms = 50.0});
}

TEST(SensorClock, ARestartedSensorIsPlacedAnew) {
  const SimulatedClocks clocks{.sensor_restart_at_s = 250.0};
  expect_within_a_millisecond(clocks);
  EXPECT_EQ(clock_errors(clocks).map.epochs.size(), 2u);
}

TEST(SensorClock, FramesOfASensorThatWasRestartedJustBeforeTheEndArePlaced) {
  expect_within_a_millisecond({.seconds = 30.0, .sensor_restart_at_s = 28.5});
  expect_within_a_millisecond({.seconds = 30.0, .sensor_restart_at_s = 1.5});
}

TEST(SensorClock, AnAgentsClockThatWasSetIsRefusedWithTheTime) {
  for (const double step_s : {3.0, -3.0, 0.05, -0.05, -4000.0}) {
    const SimulatedClocks clocks{.agent_step_at_s = 301.7, .agent_step_s = step_s};
    try {
      clock_errors(clocks);
      ADD_FAILURE() << "a step of " << step_s << " s is taken";
    } catch (const InputError& error) {
      EXPECT_EQ(error.place(), "k1/clock_exchanges_ns");
    }
  }
}

TEST(SensorClock, AnAgentsClockThatWasSetInAShortRecordingIsRefusedToo) {
  for (const double seconds : {6.0, 15.0, 40.0})
    for (const double step_s : {0.06, -0.5})
      for (const double at : {0.3, 0.5, 0.8}) {
        const SimulatedClocks clocks{
            .seconds = seconds, .agent_step_at_s = at * seconds, .agent_step_s = step_s};
        EXPECT_THROW(clock_errors(clocks), InputError) << seconds << " s, " << step_s << " s, " << at;
      }
  EXPECT_NO_THROW(clock_errors({.seconds = 6.0}));
}

// A queue on one way, as of a busy radio link, looks like another clock; its delays say that it may be none.
TEST(SensorClock, AQueueOnOneWayIsNoClockThatWasSet) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const ClockErrors errors = clock_errors({.seed = seed,
                                             .seconds = 60.0,
                                             .wire_ms = 30.0,
                                             .asymmetry_ms = 60.0,
                                             .jitter_ms = 40.0,
                                             .burst_every_s = 20.0,
                                             .burst_length_s = 11.0,
                                             .burst_ms = 200.0});
    EXPECT_LE(errors.map.agent.deviation.seconds(), 0.020) << seed;
    EXPECT_GT(errors.map.agent.bound_ns, 30'000'000) << seed;
  }
}

// A straight line keeps to the middle of a swinging clock, and `bend` states the largest distance.
TEST(SensorClock, AClockThatLeavesItsLineIsToldWithWhatItCosts) {
  for (const double sine_ms : {0.0, 0.3, 1.0, 2.0})
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const ClockErrors errors = clock_errors({.seed = seed, .sine_ms = sine_ms});
      const double agent_ms = 1e3 * errors.map.agent.deviation.seconds();
      const double sensor_ms = 1e3 * errors.map.stamps.deviation.seconds();
      EXPECT_NEAR(agent_ms, sine_ms, 0.25 + 0.2 * sine_ms) << seed;
      EXPECT_LE(errors.max_ms(), agent_ms + sensor_ms + 0.3) << sine_ms << ", " << seed;
      const double sigma_ms = 1e-6 * errors.map.agent.residual_sigma_ns;
      EXPECT_NEAR(sigma_ms, sine_ms / std::sqrt(2.0), 0.1 + 0.2 * sine_ms) << seed;
    }
}

// Ticks that go on say that the sensor was not restarted.
TEST(SensorClock, ArrivalsWhoseClockWasSetAreToldFromARestart) {
  const SimulatedClocks clocks{.seconds = 60.0};
  const auto text_of = [&](double jump_s, std::size_t at, std::size_t missing = 0) {
    auto frames = clocks.frames();
    for (std::size_t i = at; i < frames.size(); ++i)
      frames[i].stamp.arrival_ns += static_cast<std::int64_t>(1e9 * jump_s);
    frames.erase(frames.begin() + static_cast<std::ptrdiff_t>(at),
                 frames.begin() + static_cast<std::ptrdiff_t>(at + missing));
    return arrival_jump_text(fitted(clocks, frames, clocks.exchanges())).value_or("");
  };
  EXPECT_TRUE(text_of(5.0, 900).starts_with(
      "arrivals jump by 5.00 s, 30.0 s after its first frame, while its ticks go on"))
      << text_of(5.0, 900);
  EXPECT_TRUE(text_of(5.0, 900).ends_with("take 5.000 s from the arrivals from there on"))
      << text_of(5.0, 900);
  EXPECT_TRUE(text_of(-3600.0, 300).ends_with("add 3600.000 s to the arrivals from there on"))
      << text_of(-3600.0, 300);
  EXPECT_NE(text_of(0.5, 1200), "");
  EXPECT_NE(text_of(5.0, 900, 25), "");
  EXPECT_EQ(text_of(5.0, 900, 35), "");  // a second without frames may be anything
  EXPECT_EQ(text_of(0.0, 900), "");
  EXPECT_EQ(arrival_jump_text(clock_errors({.sensor_restart_at_s = 250.0}).map), std::nullopt);
}

TEST(SensorClock, AMinuteOfLateFramesIsToldAndMovesNoOther) {
  SimulatedClocks clocks{.seconds = 120.0};
  auto frames = clocks.frames();
  for (std::size_t i = 900; i < 1500; ++i) frames[i].stamp.arrival_ns += 5'000'000;
  const SensorClockMap map = fitted(clocks, frames, clocks.exchanges());
  EXPECT_NEAR(map.stamps.deviation.seconds(), 0.005, 5e-4);
  EXPECT_NEAR(map.stamps.deviation_after.seconds(), 30.0, 10.1);
  EXPECT_NEAR((map(frames[1000].stamp) - frames[1000].exposure).seconds(), 0.0, 3e-4);
}

TEST(SensorClock, UnlikeDelaysMoveTheClockByHalfTheirDifferenceAsTheBoundSays) {
  const ClockErrors errors = clock_errors({.asymmetry_ms = 2.0});
  EXPECT_NEAR(errors.quantile_ms(0.5), 1.0, 0.05);
  EXPECT_GE(1e-6 * static_cast<double>(errors.map.stamps.uncertainty.bound_ns), errors.quantile_ms(0.5));
  EXPECT_LE(1e-6 * static_cast<double>(errors.map.stamps.uncertainty.bound_ns), 1.8);
}

TEST(SensorClock, TheStatedUncertaintyOfTheOffsetHolds) {
  int beyond = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const SimulatedClocks clocks{.seed = seed, .seconds = 60.0};
    const AgentClock agent = fit_agent_clock(clocks.exchanges());
    const auto error_ns = (agent({clocks.agent_ns(0.0)}) - HostTime{SimulatedClocks::kStart_ns}).ns;
    EXPECT_LT(std::abs(error_ns), 4 * agent.sigma_ns()) << seed;
    EXPECT_LT(std::abs(error_ns), agent.bound_ns) << seed;
    beyond += std::abs(error_ns) > agent.sigma_ns();
  }
  EXPECT_GT(beyond, 4);  // nor is it far too large
  EXPECT_LT(beyond, 25);
}

TEST(SensorClock, SomeExchangesThatLieDoNoHarm) {
  const SimulatedClocks clocks{.seconds = 120.0};
  auto exchanges = clocks.exchanges();
  for (std::size_t i = 5; i < exchanges.size(); i += 20) {
    exchanges[i].t2_ns += 40'000'000;
    exchanges[i].t3_ns += 40'000'000;
  }
  exchanges[7].t4_ns = exchanges[7].t1_ns - 1;
  const AgentClock agent = fit_agent_clock(exchanges);
  EXPECT_EQ(agent.exchanges_backwards, 1u);
  EXPECT_NEAR((agent({clocks.agent_ns(60.0)}) - HostTime{SimulatedClocks::kStart_ns}).seconds(), 60.0, 1e-4);
}

// Every fourth of 48 exchanges has the least delay: its offset is 0 for six of them, 10 s, and 900 us for the
// others. Slopes between near ones are mostly 0; those of at least a third of the span have a median of 900
// us / 14 s, of all pairs of 900 us / 18 s.
TEST(SensorClock, TheDriftIsThatOfFarExchanges) {
  std::vector<ClockExchange> exchanges;
  for (std::int64_t k = 0; k < 48; ++k) {
    const std::int64_t at_ns = k * 500'000'000, offset_ns = k < 24 ? 0 : 900'000,
                       half_ns = k % 4 == 0 ? 50'000 : 500'000;
    exchanges.push_back(
        {at_ns, at_ns + half_ns + offset_ns, at_ns + half_ns + offset_ns, at_ns + 2 * half_ns});
  }
  const AgentClock agent = fit_agent_clock(exchanges);
  EXPECT_EQ(agent.exchanges_used, 12u);
  const double passed_s = (agent({22'000'000'000}) - agent({0})).seconds();
  EXPECT_NEAR(22.0 - passed_s, 22.0 * 900e-6 / 14.0, 1e-6);
}

TEST(SensorClock, WithoutExchangesBothMachinesAreTheSame) {
  EXPECT_EQ(fit_agent_clock({})({1234}).ns, 1234);
  SimulatedClocks clocks{.agent_drift_ppm = 0.0};
  const auto frames = clocks.frames();
  const SensorClockMap map = fitted(clocks, frames, {});
  EXPECT_NEAR(static_cast<double>(map(frames[900].stamp).ns - clocks.agent_ns(900.3 / 30.0)), 0.0, 1e5);
}

TEST(SensorClock, OfASensorWithoutFramesTicksAreTheHostsTime) {
  EXPECT_EQ(SensorClockMap{}(SensorTime{1234}), HostTime{1234});
}

TEST(SensorClock, OneExchangeOrTwoOrManyAtOnceGiveAnOffset) {
  const ClockExchange one{1'000'000'000, 5'000'200'000, 5'000'250'000, 1'000'450'000};
  for (std::size_t count : {1, 2, 50}) {
    const AgentClock agent = fit_agent_clock(std::vector<ClockExchange>(count, one));
    EXPECT_EQ(agent({5'000'225'000}).ns, 1'000'225'000);
    EXPECT_EQ(agent.line.drift, 0.0);
    EXPECT_EQ(agent.bound_ns, 200'000);
  }
}

TEST(SensorClock, ExchangesThatRunBackwardsAreLeftOut) {
  const ClockExchange sound{1'000'000'000, 5'000'200'000, 5'000'250'000, 1'000'450'000};
  for (const ClockExchange& backward : {ClockExchange{2'000'000'000, 9'000'000'000, 8'999'000'000,
                                                      1'999'500'000},  // answered before it was sent
                                        ClockExchange{2'000'000'000, 9'000'000'000, 8'999'000'000,
                                                      2'000'000'010},  // sent back before it came
                                        ClockExchange{2'000'000'000, 9'000'000'000, 9'000'900'000,
                                                      2'000'000'010},  // away for less than its answer took
                                        ClockExchange{2'000'000'000, 9'000'000'000, 9'000'000'010,
                                                      1'999'999'000}}) {  // back before it was sent
    const AgentClock agent = fit_agent_clock(std::vector{sound, backward});
    EXPECT_EQ(agent({5'000'225'000}).ns, 1'000'225'000);
    EXPECT_EQ(agent({9'000'225'000}).ns, 5'000'225'000);
  }
}

TEST(SensorClock, AFrameThatIsLateAloneIsNoRestart) {
  SimulatedClocks clocks{.seconds = 60.0};
  auto frames = clocks.frames();
  for (std::size_t i : {0u, 700u, 701u, 702u}) frames[i].stamp.arrival_ns += 400'000'000;
  const SensorClockMap map = fitted(clocks, frames, clocks.exchanges());
  EXPECT_EQ(map.epochs.size(), 1u);
  EXPECT_NEAR((map(frames[701].stamp) - frames[701].exposure).seconds(), 0.0, 2e-4);
}

// Ten seconds and a few frames: those say nothing of the clock.
TEST(SensorClock, AFewLateFramesBehindTheLastWindowAreNoBend) {
  SimulatedClocks clocks{.seconds = 60.1};
  auto frames = clocks.frames();
  for (std::size_t i = frames.size() - 2; i < frames.size(); ++i) frames[i].stamp.arrival_ns += 400'000'000;
  const SensorClockMap map = fitted(clocks, frames, clocks.exchanges());
  EXPECT_LT(map.stamps.deviation.seconds(), 0.002);
}

// Values up to 2^58 ns, also negative, in some of the stamps.
TEST(SensorClock, WhateverStampsSayIsPlacedOrRefused) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const SimulatedClocks clocks{.seed = seed, .seconds = 20.0};
    auto frames = clocks.frames();
    auto exchanges = clocks.exchanges();
    const RandomStream random{seed, Purpose::test, 99};
    const double scale_ns = std::exp2(58.0 * random.uniform(0));
    for (std::uint32_t i = 1; i < 100; i += 4) {
      const auto value = static_cast<std::int64_t>(random.uniform(i, -scale_ns, scale_ns));
      auto& stamp = frames[static_cast<std::size_t>(random.uniform(i + 1) * 599.0)].stamp;
      auto& exchange = exchanges[static_cast<std::size_t>(random.uniform(i + 2) * 80.0)];
      std::int64_t* const targets[] = {&stamp.arrival_ns, &exchange.t1_ns, &exchange.t2_ns,
                                       &exchange.t3_ns,   &exchange.t4_ns, &stamp.device_ticks};
      const auto target = static_cast<std::size_t>(random.uniform(i + 3) * 6.0);
      *targets[target] = target == 5 ? value / clocks.tick_ns : value;
    }
    if (seed % 7 == 0) exchanges.resize(seed % 5);
    if (seed % 5 == 0) frames.resize(seed % 4);
    try {
      const SensorClockMap map = fitted(clocks, frames, exchanges);
      for (const auto& frame : frames) map(frame.stamp);
      EXPECT_GT(map.epochs.size(), 0u);
    } catch (const InputError& error) {
      EXPECT_EQ(error.place().substr(0, 2), "k1");
    }
  }
}

// Offsets of 100, 104, 99 and 200 ms with delays of 2, 8, 4 and 1 ms, answered at 1, 2, 3 and 4 s.
TEST(LiveClock, TakesTheLeastDelayedOfTheExchangesThatItHasHad) {
  constexpr std::int64_t kMs = 1'000'000;
  const auto exchange = [](std::int64_t at_ms, std::int64_t offset_ms, std::int64_t delay_ms) {
    const std::int64_t host_ms = at_ms - offset_ms;  // when it is answered
    return ClockExchange{host_ms * kMs - delay_ms * kMs / 2, at_ms * kMs, at_ms * kMs,
                         host_ms * kMs + delay_ms * kMs / 2};
  };
  const LiveClock clock(std::vector{exchange(4000, 200, 1), exchange(1000, 100, 2), exchange(2000, 104, 8),
                                    exchange(3000, 99, 4)});
  const auto offset_ms = [&](std::int64_t t_ms) { return t_ms - clock({t_ms * kMs}).ns / kMs; };
  EXPECT_EQ(offset_ms(500), 100);  // before the first, it
  EXPECT_EQ(offset_ms(1000), 100);
  EXPECT_EQ(offset_ms(2500), 100);
  EXPECT_EQ(offset_ms(3999), 100);
  EXPECT_EQ(offset_ms(4000), 200);
  EXPECT_EQ(LiveClock({})({7}).ns, 7);
}

TEST(LiveClock, ForgetsWhatIsOlderThanEightExchanges) {
  std::vector<ClockExchange> exchanges{{0, 50, 50, 0}};  // without any delay
  for (std::int64_t i = 1; i <= 8; ++i) exchanges.push_back({100 * i - 1, 100 * i, 100 * i, 100 * i + 1});
  const LiveClock clock(exchanges);
  EXPECT_EQ(clock({799}).ns, 749);
  EXPECT_EQ(clock({800}).ns, 800);
}

TEST(SensorClock, TicksThatAreNotWhatTheySayAreRefused) {
  const SimulatedClocks clocks{.seconds = 60.0, .sensor_drift_ppm = 3000.0};
  EXPECT_THROW(fitted(clocks, clocks.frames(), clocks.exchanges()), InputError);
  EXPECT_THROW(fitted(clocks, {}, clocks.exchanges()), InputError);
}

}  // namespace
}  // namespace trilat
