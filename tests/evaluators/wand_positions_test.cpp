// SPDX-License-Identifier: MIT
// Rests of the ball on tracks made by hand, a frame every 50 ms.
#include "evaluators/calibration/wand_positions.h"

#include <gmock/gmock.h>

namespace trilat {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr double kStated_m2 = 1e-8;  // 0.1 mm an axis
const Vector3d kPlace(0.1, 0.2, 2.0);

TimedSighting sighting(std::int64_t time_ms, const Vector3d& centre_m) {
  TimedSighting result{HostTime{time_ms * kMillisecond}, {}};
  result.sighting.status = WandStatus::found;
  result.sighting.centre_in_sensor_m = centre_m;
  result.sighting.covariance_m2 = kStated_m2 * Matrix3d::Identity();
  return result;
}

using Track = std::vector<TimedSighting>;

// Still from one time to another, both included.
void hold(Track& track, std::int64_t from_ms, std::int64_t to_ms, const Vector3d& centre_m = kPlace) {
  for (std::int64_t t = from_ms; t <= to_ms; t += 50) track.push_back(sighting(t, centre_m));
}

std::vector<StaticSighting> rests_of(const Track& track) { return find_static_intervals(track, 3, {}); }

StaticSighting rest(std::size_t sensor, std::int64_t from_ms, std::int64_t to_ms) {
  StaticSighting ball;
  ball.sensor = sensor;
  ball.first = HostTime{from_ms * kMillisecond};
  ball.last = HostTime{to_ms * kMillisecond};
  return ball;
}

TEST(Rests, ABallHeldStillIsOneWithoutItsFirstAndLastTenthOfASecond) {
  Track track;
  hold(track, 0, 1000);
  const auto rests = rests_of(track);
  ASSERT_EQ(rests.size(), 1u);
  EXPECT_EQ(rests[0].sensor, 3u);
  EXPECT_EQ(rests[0].first.ns, 100 * kMillisecond);
  EXPECT_EQ(rests[0].last.ns, 900 * kMillisecond);
  EXPECT_EQ(rests[0].frames_used, 17u);
  EXPECT_EQ(rests[0].frames_left_out, 0u);
  EXPECT_LT((rests[0].centre_in_sensor_m - kPlace).norm(), 1e-12);
}

TEST(Rests, AMovingBallHasNone) {
  Track track;
  for (std::int64_t i = 0; i < 60; ++i)
    track.push_back(sighting(50 * i, kPlace + Vector3d(0.02 * static_cast<double>(i), 0.0, 0.0)));
  EXPECT_TRUE(rests_of(track).empty());
  EXPECT_TRUE(rests_of({}).empty());
}

TEST(Rests, MovementBetweenTwoPlacesSeparatesThem) {
  Track track;
  hold(track, 0, 800);
  for (std::int64_t i = 1; i <= 9; ++i)
    track.push_back(sighting(800 + 50 * i, kPlace + Vector3d(0.05 * static_cast<double>(i), 0.0, 0.0)));
  const Vector3d second = kPlace + Vector3d(0.5, 0.0, 0.0);
  hold(track, 1300, 2000, second);
  const auto rests = rests_of(track);
  ASSERT_EQ(rests.size(), 2u);
  EXPECT_LT((rests[0].centre_in_sensor_m - kPlace).norm(), 1e-12);
  EXPECT_LT((rests[1].centre_in_sensor_m - second).norm(), 1e-12);
  EXPECT_LT(rests[0].last, rests[1].first);
}

TEST(Rests, AGapOfMoreThanAFifthOfASecondEndsARestAndAShorterOneDoesNot) {
  Track apart, together;
  hold(apart, 0, 600);
  hold(apart, 850, 1450);
  hold(together, 0, 600);
  hold(together, 800, 1450);
  EXPECT_EQ(rests_of(apart).size(), 2u);
  EXPECT_EQ(rests_of(together).size(), 1u);
}

TEST(Rests, HalfASecondIsTheShortest) {
  Track half, shorter;
  hold(half, 0, 500);
  hold(shorter, 0, 450);
  EXPECT_EQ(rests_of(half).size(), 1u);
  EXPECT_TRUE(rests_of(shorter).empty());
}

TEST(Rests, AFrameThatDeviatesIsLeftOutOfTheMeanAndCounted) {
  Track track;
  hold(track, 0, 1000);
  track[10].sighting.centre_in_sensor_m.x() += 0.008;  // still within the rest's 10 mm
  const auto rests = rests_of(track);
  ASSERT_EQ(rests.size(), 1u);
  EXPECT_EQ(rests[0].frames_used, 16u);
  EXPECT_EQ(rests[0].frames_left_out, 1u);
  EXPECT_LT((rests[0].centre_in_sensor_m - kPlace).norm(), 1e-12);
}

TEST(MeanOfRest, ItsCovarianceIsTheStatedOneDividedByTheFrames) {
  Track track;
  hold(track, 0, 750);  // 16 frames that agree
  const StaticSighting ball = mean_of_rest(track, 0, 3.5);
  EXPECT_LT((ball.covariance_m2 - kStated_m2 / 16.0 * Matrix3d::Identity()).norm(), 1e-20);
}

// Ten frames 1 mm to one side and the other of the place along x: the scatter's trace is 10/9 mm2, the stated
// one's 0.03 mm2.
TEST(MeanOfRest, ScatterBeyondWhatFramesStateIsBelieved) {
  Track track;
  for (std::int64_t i = 0; i < 10; ++i)
    track.push_back(sighting(50 * i, kPlace + Vector3d(i % 2 == 0 ? 0.001 : -0.001, 0.0, 0.0)));
  const StaticSighting ball = mean_of_rest(track, 0, 3.5);
  EXPECT_EQ(ball.frames_used, 10u);
  EXPECT_LT((ball.centre_in_sensor_m - kPlace).norm(), 1e-12);
  EXPECT_NEAR(ball.covariance_m2.trace(), 10.0 / 9.0 * 1e-6 / 10.0, 1e-15);
}

TEST(MeanOfRest, OneFrameIsItself) {
  const Track track{sighting(7, kPlace)};
  const StaticSighting ball = mean_of_rest(track, 2, 3.5);
  EXPECT_EQ(ball.sensor, 2u);
  EXPECT_EQ(ball.centre_in_sensor_m, kPlace);
  EXPECT_EQ(ball.frames_used, 1u);
  EXPECT_LT((ball.covariance_m2 - kStated_m2 * Matrix3d::Identity()).norm(), 1e-20);
}

TEST(WandPositions, WhatTwoSensorsSeeAtTheSameTimeIsOne) {
  const auto positions = find_wand_positions({rest(1, 500, 1400), rest(0, 0, 1000)}, {});
  ASSERT_EQ(positions.size(), 1u);
  EXPECT_EQ(positions[0].seen.size(), 2u);
  EXPECT_EQ(positions[0].first.ns, 0);
  EXPECT_EQ(positions[0].last.ns, 1400 * kMillisecond);
}

TEST(WandPositions, WhatTheySeeAtDifferentTimesIsTwo) {
  const auto positions = find_wand_positions({rest(0, 0, 1000), rest(1, 900, 1900), rest(0, 3000, 4000)}, {});
  ASSERT_EQ(positions.size(), 3u);  // a tenth of a second in common is too little
  for (const WandPosition& position : positions) EXPECT_EQ(position.seen.size(), 1u);
  EXPECT_EQ(positions[1].seen[0].sensor, 1u);
  EXPECT_EQ(positions[2].first.ns, 3000 * kMillisecond);
}

TEST(WandPositions, ASecondRestOfASensorWithinAnothersIsLeftOut) {
  const auto positions = find_wand_positions({rest(0, 100, 800), rest(0, 1200, 1900), rest(1, 0, 2000)}, {});
  ASSERT_EQ(positions.size(), 1u);
  ASSERT_EQ(positions[0].seen.size(), 2u);
  EXPECT_EQ(positions[0].seen[0].sensor, 1u);
  EXPECT_EQ(positions[0].seen[1].last.ns, 800 * kMillisecond);
}

}  // namespace
}  // namespace trilat
