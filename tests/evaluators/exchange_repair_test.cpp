// SPDX-License-Identifier: MIT
#include "evaluators/bodies/exchange_repair.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ostream>
#include <string>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "tests/evaluators/observed_takes.h"
#include "tests/support/trials.h"

namespace trilat {
namespace {

using testing_support::observed_take;
using testing_support::ObservedTake;
using testing_support::TakeSpec;

bool is_seen(const ObservedBody& body) {
  return std::ranges::any_of(body.state,
                             [](TrackingState state) { return state != TrackingState::not_tracked; });
}

struct Score {
  std::size_t stretches = 0, repaired = 0;  // repaired: at least 95 % of the instants
  std::size_t right = 0, touched = 0;       // instants of a sensor whose labels were right
  double seconds = 0.0;
  std::size_t instants = 0;
};

void add_stretches(const ObservedTake& take, const SideSwapRepair& repair, std::size_t sensor, Score& score) {
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
  const SideSwapRepair repair = find_exchanges(take.tracks, take.world_from_sensor, {});
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
  const std::uint64_t takes = trials(60);
  Score all;
  for (const Activity activity : {Activity::walking, Activity::arm_swing, Activity::leg_crossing}) {
    Score score;
    for (std::uint64_t take = 0; take < takes; ++take)
      add_take({activity, scenario.sensors, scenario.exchange_probability, scenario.upper_body_only,
                scenario.toes_follow_labels, take, 900},
               score);
    std::printf(
        "%-22s activity %d: %zu of %zu stretches repaired, %zu of %zu right instants touched, %.2f us an "
        "instant\n",
        scenario.name, static_cast<int>(activity), score.repaired, score.stretches, score.touched,
        score.right, 1e6 * score.seconds / static_cast<double>(score.instants));
    all.stretches += score.stretches;
    all.repaired += score.repaired;
    all.right += score.right;
    all.touched += score.touched;
  }
  EXPECT_GE(static_cast<double>(all.repaired), scenario.least_repaired * static_cast<double>(all.stretches));
  EXPECT_LE(static_cast<double>(all.touched), scenario.most_touched * static_cast<double>(all.right));
}

// Standing with only the upper body in view, all back views exchanged: nothing but the arms tells front from
// back. One sensor alone then leaves much as it is; toes that follow wrong labels are beyond repair while the
// person stands.
INSTANTIATE_TEST_SUITE_P(Rigs, Exchanges,
                         testing::Values(Scenario{"four", 4, 0.5, false, false, 0.99, 0.001},
                                         Scenario{"four_always", 4, 1.0, false, false, 0.99, 0.001},
                                         Scenario{"four_never", 4, 0.0, false, false, 0.99, 0.001},
                                         Scenario{"four_upper", 4, 0.5, true, false, 0.99, 0.001},
                                         Scenario{"four_upper_always", 4, 1.0, true, false, 0.99, 0.001},
                                         Scenario{"four_toes", 4, 0.5, false, true, 0.99, 0.001},
                                         Scenario{"eight", 8, 0.5, false, false, 0.99, 0.001},
                                         Scenario{"eight_always", 8, 1.0, false, false, 0.99, 0.001},
                                         Scenario{"three", 3, 0.5, false, false, 0.99, 0.001},
                                         Scenario{"three_always", 3, 1.0, false, false, 0.99, 0.001},
                                         Scenario{"two", 2, 0.5, false, false, 0.99, 0.001},
                                         Scenario{"two_always", 2, 1.0, false, false, 0.99, 0.001},
                                         Scenario{"one", 1, 0.5, false, false, 0.95, 0.001},
                                         Scenario{"one_always", 1, 1.0, false, false, 0.95, 0.001},
                                         Scenario{"one_upper", 1, 0.5, true, false, 0.7, 0.005},
                                         Scenario{"one_upper_always", 1, 1.0, true, false, 0.5, 0.005},
                                         Scenario{"four_toes_always", 4, 1.0, false, true, 0.9, 0.05}),
                         [](const auto& scenario) { return std::string(scenario.param.name); });

std::size_t count_of(const SideSwapRepair& repair) {
  return static_cast<std::size_t>(std::ranges::count(repair.sides_swapped, 1));
}

TEST(SideSwapRepair, OneBadInstantOfOneJointChangesNothing) {
  ObservedTake take = observed_take({Activity::walking, 4, 0.0, false, false, 3, 300});
  ObservedBody& body = take.tracks.at(150, 1);
  std::swap(body.joint_in_sensor_m[4], body.joint_in_sensor_m[8]);  // the shoulders
  EXPECT_EQ(count_of(find_exchanges(take.tracks, take.world_from_sensor, {})), 0u);
}

TEST(SideSwapRepair, ItsStretchesAreCountedForEachSensor) {
  ObservedTake take = observed_take({Activity::arm_swing, 4, 0.0, false, false, 5, 300});
  std::size_t back = 0;
  const auto motion_at_start = generated_motion(draw_person(11, 5, 1.70, 0.17), Activity::arm_swing)(0.0);
  for (std::size_t s = 1; s < 4; ++s)
    if (testing_support::facing(motion_at_start, take.world_from_sensor[s]) <
        testing_support::facing(motion_at_start, take.world_from_sensor[back]))
      back = s;
  for (std::size_t i = 0; i < 300; ++i)
    if ((i >= 50 && i < 90) || (i >= 150 && i < 205))
      testing_support::exchange_sides(take.tracks.at(i, back));
  const SideSwapRepair repair = find_exchanges(take.tracks, take.world_from_sensor, {});
  for (std::size_t s = 0; s < 4; ++s) EXPECT_EQ(repair.stretches[s], s == back ? 2u : 0u);
  EXPECT_TRUE(repair.at(50, back));
  EXPECT_FALSE(repair.at(49, back));
  EXPECT_TRUE(repair.at(204, back));
  EXPECT_FALSE(repair.at(205, back));
}

TEST(SideSwapRepair, UndoingGivesBackTheTrueLabelsAndTwiceTheOldOnes) {
  const ObservedTake take = observed_take({Activity::walking, 4, 1.0, false, false, 4, 300});
  BodyTracks tracks = take.tracks;
  const SideSwapRepair repair = find_exchanges(tracks, take.world_from_sensor, {});
  EXPECT_GT(count_of(repair), 0u);
  undo_exchanges(tracks, repair);
  EXPECT_EQ(count_of(find_exchanges(tracks, take.world_from_sensor, {})), 0u);
  undo_exchanges(tracks, repair);
  for (std::size_t i = 0; i < tracks.instants(); ++i) {
    for (std::size_t s = 0; s < 4; ++s) {
      EXPECT_EQ(tracks.at(i, s).state, take.tracks.at(i, s).state);
      EXPECT_EQ(tracks.at(i, s).joint_in_sensor_m, take.tracks.at(i, s).joint_in_sensor_m);
    }
  }
}

TEST(SideSwapRepair, WhereNothingTellsFrontFromBackNothingIsTouched) {
  ObservedTake take = observed_take({Activity::standing, 4, 1.0, true, false, 6, 300});
  for (std::size_t i = 0; i < 300; ++i)
    for (std::size_t s = 0; s < 4; ++s)
      for (const Joint joint : {Joint::wrist_left, Joint::wrist_right, Joint::elbow_left, Joint::elbow_right})
        take.tracks.at(i, s).state[static_cast<std::size_t>(joint)] = TrackingState::not_tracked;
  EXPECT_EQ(count_of(find_exchanges(take.tracks, take.world_from_sensor, {})), 0u);
}

TEST(SideSwapRepair, NoInstantsNoBodiesAndNoSensorsAreNothingToRepair) {
  const std::vector<RigidTransform> two(2);
  EXPECT_TRUE(find_exchanges(BodyTracks(0, 2), two, {}).sides_swapped.empty());
  EXPECT_EQ(count_of(find_exchanges(BodyTracks(5, 2), two, {})), 0u);
  EXPECT_TRUE(find_exchanges(BodyTracks(0, 0), {}, {}).sides_swapped.empty());
}

TEST(SideSwapRepair, PosesAndTracksMustBelongTogether) {
  EXPECT_THROW((void)find_exchanges(BodyTracks(5, 2), std::vector<RigidTransform>(3), {}), InternalError);
  BodyTracks tracks(5, 2);
  EXPECT_THROW(undo_exchanges(tracks, {3, std::vector<std::uint8_t>(15), {}}), InternalError);
}

}  // namespace
}  // namespace trilat
