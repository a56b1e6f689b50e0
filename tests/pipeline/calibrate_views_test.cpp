// SPDX-License-Identifier: MIT
// From hand-made sightings of a wand to sensor poses.
#include <fmt/format.h>

#include "datasets/base/files.h"
#include "datasets/session/session_writer.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/wand_views.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string complaint_about(WandObservations views, const CalibrateWandOptions& options = {}) {
  return message_of([&] { calibrate_views(std::move(views), "session.h5", options); });
}

TEST(CalibrateViews, ExactSightingsGiveExactPoses) {
  const auto rig = rig_of(3);
  const WandCalibration result = calibrate_views(views_of(rig, kPlaces, always), "session.h5", {});
  for (std::size_t s = 0; s < 3; ++s)
    expect_pose(result.calibration.sensors[s], wand_from_world(kPlaces) * rig[s], 1e-6, 1e-4);
}

// Centimetres apart, at so few places that an odd error of its depth would explain them.
TEST(CalibrateViews, ASensorWhosePositionsNearlyAllDisagreeIsNamed) {
  WandObservations views =
      views_of(rig_of(4), kPlaces, [](std::size_t s, std::size_t p) { return s < 3 || p < 4; });
  for (std::size_t p = 0; p < 4; ++p)
    views.positions[p].seen[3].centre_in_sensor_m.z() += p % 2 == 0 ? 0.03 : -0.03;
  EXPECT_THAT(
      complaint_about(views),
      StartsWith("session.h5: sensor \"k4\" agrees with the others only if its depth is off by more"));
}

TEST(CalibrateViews, AMeasuredMovementThatTheSensorsDidNotSeeIsRefusedWithBothLengths) {
  CalibrateWandOptions options;
  const double truth_m = (kPlaces[1] - kPlaces[0]).norm();
  options.baseline_m = truth_m;
  EXPECT_EQ(complaint_about(views_of(rig_of(3), kPlaces, always), options), "no error");
  options.baseline_m = 2.0 * truth_m;
  EXPECT_THAT(complaint_about(views_of(rig_of(3), kPlaces, always), options),
              AllOf(StartsWith("--movement-m: is "), HasSubstr(fmt::format("{:.3f}", 2.0 * truth_m)),
                    HasSubstr(fmt::format("move by {:.3f} m", truth_m))));
}

TEST(CalibrateViews, FirstPlacesThatAreTooNearEachOtherAreRefused) {
  std::vector<Vector3d> places = kPlaces;
  places[1] = places[0] + Vector3d(0.2, 0.0, 0.0);
  EXPECT_THAT(complaint_about(views_of(rig_of(3), places, always)),
              AllOf(HasSubstr("0.20 m apart"), HasSubstr("0.3 m at least")));
}

TEST(CalibrateViews, ARestThatDriftedIntoTwoIsOnePlace) {
  std::vector<Vector3d> places = kPlaces;
  places.insert(places.begin() + 1, places[0] + Vector3d(0.012, 0.0, 0.0));
  const auto rig = rig_of(3);
  const WandCalibration result = calibrate_views(views_of(rig, places, always), "session.h5", {});
  EXPECT_EQ(result.calibration.positions, kPlaces.size());
  for (std::size_t s = 0; s < 3; ++s)
    expect_pose(result.calibration.sensors[s], wand_from_world(kPlaces) * rig[s], 1e-6, 1e-4);
}

TEST(CalibrateViews, APlaceThatOneSensorSawAloneSaysNothing) {
  std::vector<Vector3d> places = kPlaces;
  places.insert(places.begin(), Vector3d(0.4, 1.3, -0.2));
  const auto rig = rig_of(3);
  const WandCalibration result = calibrate_views(
      views_of(rig, places, [](std::size_t s, std::size_t p) { return p > 0 || s == 1; }), "session.h5", {});
  EXPECT_EQ(result.calibration.positions, kPlaces.size());
  for (std::size_t s = 0; s < 3; ++s) {
    EXPECT_EQ(result.calibration.sensors[s].used, kPlaces.size());
    expect_pose(result.calibration.sensors[s], wand_from_world(kPlaces) * rig[s], 1e-6, 1e-4);
  }
}

TEST(CalibrateViews, ASensorThatDisagreesAtMoreThanAThirdOfItsPlacesIsAnError) {
  std::vector<Vector3d> places = kPlaces;
  for (int i = 0; i < 10; ++i)
    places.emplace_back(0.6 * std::sin(2.0 * i), 0.5 + 0.12 * i, 0.6 * std::cos(2.0 * i));
  WandObservations views = views_of(rig_of(4), places, always);
  for (std::size_t p = 6; p < 15; ++p)
    views.positions[p].seen[3].centre_in_sensor_m.x() += p % 2 == 0 ? 0.04 : -0.03;
  EXPECT_THAT(complaint_about(views),
              AllOf(StartsWith("session.h5: sensor \"k4\" disagrees with the others at "),
                    HasSubstr("are the intrinsics its own")));
}

TEST(CalibrateViews, AWrongSightingIsListedWithItsPlaceAndTime) {
  WandObservations views = views_of(rig_of(4), kPlaces, always);
  views.positions[5].seen[1].centre_in_sensor_m.x() += 0.08;
  const WandCalibration result = calibrate_views(views, "session.h5", {});
  ASSERT_EQ(result.calibration.rejected.size(), 1u);
  const RejectedSighting& rejected = result.calibration.rejected[0];
  EXPECT_EQ(rejected.sensor, "k2");
  EXPECT_EQ(rejected.position, 6u);
  EXPECT_NEAR(rejected.time_s, 6.0, 1e-9);
  EXPECT_NEAR(rejected.off_by_m.value(), 0.08, 1e-3);
  EXPECT_EQ(result.calibration.sensors[1].left_out, 1u);
}

TEST(CalibrateViews, WithAnExportOfTheBallPosesAreInOptiTracksWorld) {
  const ScratchFolder folder;
  write_wand_export(folder / "wand.csv", true);
  const auto rig = rig_of(3);
  CalibrateWandOptions options;
  options.world = WandInWorld{folder / "wand.csv", "Wand", kStart_ns};
  const WandCalibration result = calibrate_views(views_of(rig, kPlaces, always), "session.h5", options);
  EXPECT_EQ(result.calibration.world, "optitrack");
  for (std::size_t s = 0; s < 3; ++s) expect_pose(result.calibration.sensors[s], rig[s], 1e-4, 0.01);
}

// Depth images flipped from left to right: x of all that the sensor sees has the other sign.
TEST(CalibrateViews, FlippedDepthImagesAreNamed) {
  const ScratchFolder folder;
  write_wand_export(folder / "wand.csv", true);
  CalibrateWandOptions tied;
  tied.world = WandInWorld{folder / "wand.csv", "Wand", kStart_ns};
  const auto complaint = [&](std::size_t sensors, const std::vector<std::size_t>& flipped,
                             const CalibrateWandOptions& options = {}) {
    WandObservations views = views_of(rig_of(sensors), kPlaces, always);
    for (WandPosition& position : views.positions)
      for (const std::size_t s : flipped) position.seen[s].centre_in_sensor_m.x() *= -1.0;
    return complaint_about(std::move(views), options);
  };
  const std::string remedy =
      " shows the ball's places mirrored: its depth images are flipped from left to right; turn every row of "
      "them "
      "round";
  EXPECT_EQ(complaint(4, {2}), "session.h5: sensor \"k3\"" + remedy);
  EXPECT_EQ(complaint(3, {0}), "session.h5: sensor \"k1\"" + remedy);
  EXPECT_EQ(complaint(2, {1}), "session.h5: one of the sensors \"k1\" and \"k2\"" + remedy);
  EXPECT_EQ(complaint(2, {1}, tied), "session.h5: sensor \"k2\"" + remedy);
  EXPECT_THAT(
      complaint(3, {0, 2}, tied),
      StartsWith("session.h5: sensors \"k1\" and \"k3\" show the ball's places mirrored: their depth"));
  EXPECT_THAT(complaint(3, {0, 1, 2}, tied),
              AllOf(HasSubstr("wand.csv: shows the ball's places as the mirror image"),
                    HasSubstr("left-handed axes, or all depth images are flipped")));
  EXPECT_EQ(complaint(3, {}, tied), "no error");
}

TEST(CalibrateViews, AKnownPlaceIsAsSureAsItsSamplesAndOptiTracksCalibration) {
  WandInWorld world{"wand.csv", "Wand", 0, 0.0002, WandTrack{}};
  std::vector<WandPosition> positions;
  for (std::int64_t p = 0; p < 3; ++p) {
    positions.push_back({{100 * p}, {100 * p + 50}, {}});
    for (std::int64_t i = 0; i < 4; ++i) {
      world.track->times.push_back({100 * p + 10 * i});
      world.track->position_m.push_back(kPlaces[static_cast<std::size_t>(p)] +
                                        Vector3d(i % 2 == 0 ? 0.0003 : -0.0003, 0.0, 0.0));
    }
  }
  const auto known = known_positions(world, positions);
  ASSERT_EQ(known.size(), 3u);
  for (const ControlPoint& point : known) {
    EXPECT_LT((point.point_in_world_m - kPlaces[point.point]).norm(), 1e-12);
    EXPECT_NEAR(point.sigma_m, std::sqrt(0.0002 * 0.0002 + 0.01e-6), 1e-12);
  }
}

TEST(CalibrateViews, AnExportThatDoesNotShowTheWandAtRestIsRefused) {
  const ScratchFolder folder;
  write_wand_export(folder / "moving.csv", false);
  write_wand_export(folder / "wand.csv", true);
  const WandObservations views = views_of(rig_of(2), kPlaces, always);
  const auto complaint = [&](const char* file, const char* asset, std::int64_t start_ns) {
    CalibrateWandOptions options;
    options.world = WandInWorld{folder / file, asset, start_ns};
    return complaint_about(views, options);
  };
  const std::string at_none = "shows \"Wand\" at rest at 0 of the 8 wand positions; three are needed";
  EXPECT_THAT(complaint("moving.csv", "Wand", kStart_ns), AllOf(HasSubstr("moving.csv"), HasSubstr(at_none)));
  EXPECT_THAT(complaint("wand.csv", "Wand", kStart_ns + 3'600'000'000'000),
              AllOf(HasSubstr("wand.csv"), HasSubstr(at_none), HasSubstr("on the host clock right?")));
  EXPECT_THAT(complaint("wand.csv", "Ball", kStart_ns), AllOf(HasSubstr("Ball"), HasSubstr("Wand")));
}

}  // namespace
}  // namespace trilat
