// SPDX-License-Identifier: MIT
#include "pipeline/calibration/calibrate_bodies.h"

#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/base/units.h"
#include "pipeline/study/study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/support/scratch.h"
#include "tests/support/trials.h"

namespace trilat {
namespace {

using testing::HasSubstr;

// How far the poses are from the truth, both beside the reference sensor's; (turn, rad; position, m) and the
// stated deviations.
struct BodiesError {
  Eigen::Matrix<double, 6, 1> off;
  Eigen::Matrix<double, 6, 6> covariance;
};

// The declared tracker's errors that average out.
BodyTrackerSpec unbiased_tracker() {
  const BodyTrackerSpec& all = default_body_tracker();
  BodyTrackerSpec tracker = exact_body_tracker();
  tracker.jitter_sigma_m = all.jitter_sigma_m;
  tracker.drift_sigma_m = all.drift_sigma_m;
  tracker.view_drift_sigma_m = all.view_drift_sigma_m;
  tracker.own_drift_sigma_m = all.own_drift_sigma_m;
  tracker.drift_path_m = all.drift_path_m;
  return tracker;
}

// Somebody walks for ten seconds; gives the recording.
std::filesystem::path record_walk(const std::filesystem::path& folder, std::uint64_t seed,
                                  const BodyTrackerSpec& tracker) {
  SimulationSpec spec = walking_spec(1, 10.0);
  spec.seed = seed;
  spec.body_tracker = tracker;
  return simulate_into(folder, spec).takes.at(0).session;
}

std::vector<BodiesError> errors_from_bodies(const std::filesystem::path& folder, std::uint64_t run,
                                            const BodyTrackerSpec& tracker, std::size_t instants) {
  const std::filesystem::path walk = record_walk(folder, 1 + run, tracker);
  std::vector<RigidTransform> truth;
  for (const SensorPose& pose : read_calibration(folder / "calibration.json").sensors)
    truth.push_back(pose.world_from_sensor);
  const BodyCalibration result = calibrate_bodies(walk, {.instants = instants});
  EXPECT_EQ(result.calibration.sensors.size(), truth.size());
  EXPECT_EQ(result.calibration.method, "bodies");
  const RigidTransform frame_from_world =
      result.calibration.sensors[result.reference].world_from_sensor * truth[result.reference].inverse();
  std::vector<BodiesError> errors;
  for (std::size_t s = 0; s < truth.size(); ++s) {
    if (s == result.reference) continue;
    const SensorPose& pose = result.calibration.sensors[s];
    const RigidTransform expected = frame_from_world * truth[s];
    const Eigen::AngleAxisd turn(pose.world_from_sensor.rotation * expected.rotation.conjugate());
    BodiesError error;
    error.off << turn.angle() * turn.axis(), pose.world_from_sensor.translation_m - expected.translation_m;
    error.covariance = pose.covariance.value();
    errors.push_back(error);
  }
  return errors;
}

TEST(CalibrateBodies, WithoutTrackerBiasTheyPlaceTheSensorsWithinTwoCentimetres) {
  const ScratchFolder folder;
  const auto errors = errors_from_bodies(folder / "campaign", 0, unbiased_tracker(), 30);
  ASSERT_FALSE(errors.empty());
  for (const BodiesError& error : errors) {
    EXPECT_LT(error.off.tail<3>().norm(), 0.02);
    EXPECT_LT(error.off.head<3>().norm(), 0.5 * kRadPerDegree);
  }
}

// The mean of six where the stated covariance is right; 13 while a unit's depth error was not in it.
TEST(CalibrateBodies, TheStatedCovarianceHoldsWhatAllJointsShare) {
  const std::uint64_t runs = trials(80);
  double squares = 0.0, poses = 0.0;
  for (std::uint64_t run = 0; run < runs; ++run) {
    const ScratchFolder folder;
    for (const BodiesError& error :
         errors_from_bodies(folder / "campaign", run, default_body_tracker(), 60)) {
      squares += error.off.dot(error.covariance.ldlt().solve(error.off));
      poses += 1.0;
    }
  }
  ASSERT_GT(poses, 2.0 * static_cast<double>(runs));
  EXPECT_GT(squares / poses, 3.0);
  EXPECT_LT(squares / poses, 9.0);
}

TEST(CalibrateBodies, ARecordingThatIsReplacedMeanwhileIsRefused) {
  const ScratchFolder folder;
  std::filesystem::rename(record_walk(folder / "campaign", 1, unbiased_tracker()), folder / "walk.h5");
  write_file(folder / "other.h5", "something else");
  const auto replace = [&] {
    std::error_code done;
    std::filesystem::rename(folder / "other.h5", folder / "walk.h5", done);
    return false;
  };
  EXPECT_THAT(
      message_of([&] { calibrate_bodies(folder / "walk.h5", {.instants = 8, .stop_requested = replace}); }),
      HasSubstr("walk.h5: changed while it was being evaluated; run again"));
}

// The bias of a joint decides, and time does not average it out: few instants are enough.
TEST(CalibrateBodies, WithTrackerBiasTheStatedIntervalsHold) {
  const ScratchFolder folder;
  int held = 0, asked = 0;
  for (std::uint64_t run = 0; run < 6; ++run)
    for (const BodiesError& error : errors_from_bodies(folder / "campaign", run, default_body_tracker(), 8))
      for (int axis = 0; axis < 6; ++axis, ++asked)
        held += std::abs(error.off[axis]) <= 1.96 * std::sqrt(error.covariance(axis, axis));
  EXPECT_EQ(asked, 6 * 3 * 6);
  EXPECT_GE(held, 0.85 * asked);
}

}  // namespace
}  // namespace trilat
