// SPDX-License-Identifier: MIT
#include "evaluators/bodies/exchange_repair.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>

#include <gmock/gmock.h>

#include "tests/evaluators/observed_takes.h"

namespace trilat {
namespace {

using testing_support::observed_take;
using testing_support::ObservedTake;
using testing_support::TakeSpec;

bool is_seen(const ObservedBody& body) {
  return std::any_of(body.state.begin(), body.state.end(),
                     [](TrackingState state) { return state != TrackingState::not_tracked; });
}

struct Score {
  std::size_t stretches = 0, repaired = 0;  // repaired: at least 95 % of the instants
  std::size_t right = 0, touched = 0;       // instants of a sensor whose labels were right
  double seconds = 0.0;
  std::size_t instants = 0;
};

void add_stretches(const ObservedTake& take, const ExchangeRepair& repair, std::size_t sensor, Score& score) {
  std::size_t length = 0, found = 0;
  for (std::size_t i = 0; i <= take.tracks.instants(); ++i) {
    if (i < take.tracks.instants() && take.was_exchanged(i, sensor)) {
      const bool seen = is_seen(take.tracks.at(i, sensor));
      length += seen;
      found += seen && repair.at(i, sensor);
      continue;
    }
    if (length > 0) {
      ++score.stretches;
      score.repaired += static_cast<double>(found) >= 0.95 * static_cast<double>(length);
    }
    length = found = 0;
  }
}

void add_take(const TakeSpec& spec, Score& score) {
  const ObservedTake take = observed_take(spec);
  const auto start = std::chrono::steady_clock::now();
  const ExchangeRepair repair = find_exchanges(take.tracks, take.world_from_sensor, {});
  score.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  score.instants += spec.instants;
  for (std::size_t s = 0; s < spec.sensors; ++s) {
    add_stretches(take, repair, s, score);
    for (std::size_t i = 0; i < spec.instants; ++i) {
      if (take.was_exchanged(i, s) || !is_seen(take.tracks.at(i, s))) continue;
      ++score.right;
      score.touched += repair.at(i, s);
    }
  }
}

struct Scenario {
  const char* name;
  std::size_t sensors;
  double exchange_probability;
  bool upper_body_only, toes_follow_labels;
  double least_repaired, most_touched;
};

void PrintTo(const Scenario& scenario, std::ostream* out) { *out << scenario.name; }

class Exchanges : public testing::TestWithParam<Scenario> {};

TEST_P(Exchanges, AreRepairedAndWhatIsRightIsLeftAlone) {
  const Scenario& scenario = GetParam();
  const char* more = std::getenv("TRILAT_TAKES");
  const std::uint64_t takes = more ? std::strtoull(more, nullptr, 10) : 7;
  Score all;
  for (const Activity activity : {Activity::walking, Activity::arm_swing, Activity::leg_crossing}) {
    Score score;
    for (std::uint64_t take = 0; take < takes; ++take)
      add_take({activity, scenario.sensors, scenario.exchange_probability, scenario.upper_body_only,
                scenario.toes_follow_labels, take, 900}, score);
    std::printf("%-22s activity %d: %zu of %zu stretches repaired, %zu of %zu right instants touched, %.2f us an instant\n",
                scenario.name, static_cast<int>(activity), score.repaired, score.stretches, score.touched, score.right,
                1e6 * score.seconds / static_cast<double>(score.instants));
    all.stretches += score.stretches;
    all.repaired += score.repaired;
    all.right += score.right;
    all.touched += score.touched;
  }
  EXPECT_GE(static_cast<double>(all.repaired), scenario.least_repaired * static_cast<double>(all.stretches));
  EXPECT_LE(static_cast<double>(all.touched), scenario.most_touched * static_cast<double>(all.right));
}

INSTANTIATE_TEST_SUITE_P(
    Rigs, Exchanges,
    testing::Values(Scenario{"four", 4, 0.5, false, false, 0.99, 0.001},
                    Scenario{"four_always", 4, 1.0, false, false, 0.99, 0.001},
                    Scenario{"four_never", 4, 0.0, false, false, 0.99, 0.001},
                    Scenario{"four_upper", 4, 0.5, true, false, 0.99, 0.001},
                    Scenario{"four_upper_always", 4, 1.0, true, false, 0.99, 0.001},
                    Scenario{"eight", 8, 0.5, false, false, 0.99, 0.001},
                    Scenario{"eight_always", 8, 1.0, false, false, 0.99, 0.001},
                    Scenario{"three", 3, 0.5, false, false, 0.99, 0.001},
                    Scenario{"three_always", 3, 1.0, false, false, 0.99, 0.001},
                    Scenario{"two", 2, 0.5, false, false, 0.99, 0.001},
                    Scenario{"two_always", 2, 1.0, false, false, 0.99, 0.001},
                    Scenario{"four_toes", 4, 0.5, false, true, 0.99, 0.001},
                    Scenario{"four_toes_always", 4, 1.0, false, true, 0.0, 1.0},
                    Scenario{"one_toes", 1, 0.5, false, true, 0.0, 0.001},
                    Scenario{"one", 1, 0.5, false, false, 0.0, 0.001},
                    Scenario{"one_always", 1, 1.0, false, false, 0.0, 0.001},
                    Scenario{"one_upper", 1, 0.5, true, false, 0.0, 0.001},
                    Scenario{"one_upper_always", 1, 1.0, true, false, 0.0, 0.001}),
    [](const auto& scenario) { return std::string(scenario.param.name); });

}  // namespace
}  // namespace trilat
