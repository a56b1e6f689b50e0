// SPDX-License-Identifier: MIT
#include <string>

#include <gtest/gtest.h>

#include "tests/datasets/simulated_clocks.h"

namespace trilat {
namespace {

struct Hardship {
  std::string name;
  SimulatedClocks clocks;
};

std::vector<Hardship> hardships() {
  return {{"none", {}},
          {"exchanges in the first 9 s", {.exchanges_until_s = 9.0}},
          {"exchanges in the first 60 s", {.exchanges_until_s = 60.0}},
          {"one exchange", {.exchanges_until_s = 0.0}},
          {"two exchanges", {.exchanges_until_s = 0.25}},
          {"a queue on the way back", {.jitter_back_ms = 20.0}},
          {"a queue on the way there", {.jitter_ms = 20.0, .jitter_back_ms = 0.5}},
          {"a queue and a swinging clock", {.sine_ms = 2.0, .jitter_back_ms = 20.0}},
          {"a queue, exchanges in the first 60 s", {.jitter_back_ms = 20.0, .exchanges_until_s = 60.0}},
          {"2 ms more one way", {.asymmetry_ms = 2.0}},
          {"bursts", {.burst_every_s = 120.0, .burst_length_s = 40.0, .burst_ms = 50.0}},
          {"a step of 2.5 ms", {.agent_step_at_s = 301.7, .agent_step_s = 0.0025}},
          {"a step of 3.4 ms", {.agent_step_at_s = 301.7, .agent_step_s = 0.0034}}};
}

TEST(ClockDoubt, NinetyNineFramesOfAHundredLieWithinWhatIsStated) {
  for (const Hardship& hardship : hardships())
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      SimulatedClocks clocks = hardship.clocks;
      clocks.seed = seed;
      const ClockErrors errors = clock_errors(clocks);
      const double bound_ms = 1e-6 * static_cast<double>(errors.map.stamps.uncertainty.bound_ns);
      const double sigma_ms = 1e-6 * static_cast<double>(errors.map.stamps.uncertainty.sigma_ns);
      EXPECT_GT(errors.share_within(bound_ms + 4.0 * sigma_ms), 0.99) << hardship.name << ", seed " << seed;
      EXPECT_GT(sigma_ms, 0.0) << hardship.name;
    }
}

TEST(ClockDoubt, AFullRecordingIsNotCalledUncertain) {
  const StampEvidence stamps = clock_errors({}).map.stamps;
  EXPECT_LT(stamps.uncertainty.sigma_ns, 100'000);
  EXPECT_LT(stamps.uncertainty.bound_ns, 700'000);
}

TEST(ClockDoubt, AQueueOnOneWayLeavesFramesWithinTwoMilliseconds) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    EXPECT_LE(clock_errors({.seed = seed, .jitter_back_ms = 20.0}).max_ms(), 2.0) << seed;
    EXPECT_LE(clock_errors({.seed = seed, .jitter_ms = 20.0, .jitter_back_ms = 0.5}).max_ms(), 2.0) << seed;
  }
}

TEST(ClockDoubt, FramesOutsideTheExchangesAreTold) {
  EXPECT_NEAR(clock_errors({.exchanges_until_s = 60.0}).map.stamps.uncertainty.outside.seconds(), 540.0, 0.5);
  EXPECT_LT(clock_errors({}).map.stamps.uncertainty.outside.seconds(), 0.5);
}

TEST(ClockDoubt, TheLatenessOfArrivalsIsTold) {
  const StampEvidence stamps = clock_errors({.arrival_jitter_ms = 3.0}).map.stamps;
  EXPECT_NEAR(stamps.lateness_median.seconds(), 0.003 * std::log(2.0), 2e-4);
  EXPECT_NEAR(stamps.lateness_p99.seconds(), 0.003 * std::log(100.0), 1e-3);
}

TEST(ClockDoubt, ADriftThatIsLeftOutIsTold) {
  const ClockErrors errors =
      clock_errors({.seconds = 4.0, .sensor_drift_ppm = 5000.0, .arrival_jitter_ms = 0.1});
  EXPECT_NEAR(errors.map.stamps.drift_left_out, -5e-3, 2e-4);
  EXPECT_EQ(clock_errors({}).map.stamps.drift_left_out, 0.0);
}

}  // namespace
}  // namespace trilat
