// SPDX-License-Identifier: MIT
// The paper's calibration from two positions of the wand, as printed and corrected.
#include "datasets/session/session_writer.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/wand_views.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

// Writes one body frame for each sensor.
void record_floors(const std::filesystem::path& path, const std::vector<RigidTransform>& rig) {
  SessionWriter writer(path, header_of(rig.size(), false));
  for (std::size_t s = 0; s < rig.size(); ++s)
    writer.add_body_frame(s, floor_seen_from(rig[s], {0, 0, kStart_ns}));
  writer.finish();
}

std::vector<std::optional<FloorPlane>> read_floors(const std::filesystem::path& path) {
  const SessionReader session(path);
  std::vector<std::optional<FloorPlane>> floors;
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s)
    floors.push_back(floor_seen_by(session, s));
  return floors;
}

const std::vector<std::optional<FloorPlane>> kNoFloors(4);
const std::vector<Vector3d> kTwoPlaces{{0.0, 1.0, 0.0}, {0.6, 1.0, 0.2}};
const TwoPositionOptions kCorrected{
    .trajectory_axis = TrajectoryAxis::z, .signed_angle = true, .translation = true};

TEST(CalibrateTwoPositions, CorrectedTheyUseEachSensorsFloor) {
  const ScratchFolder folder;
  const auto rig = rig_of(4);
  record_floors(folder / "session.h5", rig);
  const WandObservations views = views_of(rig, kTwoPlaces, always);
  const RigidTransform wand =
      wand_from_world({kTwoPlaces[0], kTwoPlaces[1], kTwoPlaces[0] + Vector3d::UnitY()});
  const auto recorded = read_floors(folder / "session.h5");
  const Calibration calibration =
      calibrate_two_positions(views, "session.h5", kCorrected, std::nullopt, recorded);
  ASSERT_EQ(calibration.sensors.size(), 4u);
  for (std::size_t s = 0; s < 4; ++s) expect_pose(calibration.sensors[s], wand * rig[s], 1e-6, 1e-4);
  // Taken to stand upright, they keep the angle by which they look up or down.
  const Calibration upright =
      calibrate_two_positions(views, "session.h5", kCorrected, std::nullopt, kNoFloors);
  EXPECT_GT(upright.sensors[3].world_from_sensor.rotation.angularDistance((wand * rig[3]).rotation),
            20.0 * kRadPerDegree);
}

TEST(CalibrateTwoPositions, AsPrintedEverySensorIsAtTheOrigin) {
  const Calibration calibration =
      calibrate_two_positions(views_of(rig_of(2), kTwoPlaces, always), "session.h5", {}, 0.7, kNoFloors);
  EXPECT_EQ(calibration.method, "two positions, as printed");
  for (const SensorPose& pose : calibration.sensors)
    EXPECT_EQ(pose.world_from_sensor.translation_m, Vector3d::Zero());
}

TEST(CalibrateTwoPositions, ASensorThatDidNotSeeBothPlacesIsNamed) {
  const auto complaint = [&](const WandObservations& views, const TwoPositionOptions& options) {
    return message_of(
        [&] { static_cast<void>(calibrate_two_positions(views, "session.h5", options, 0.7, kNoFloors)); });
  };
  for (const TwoPositionOptions& options : {TwoPositionOptions{}, kCorrected}) {
    EXPECT_THAT(complaint(views_of(rig_of(3), kTwoPlaces,
                                   [](std::size_t s, std::size_t p) { return s != 1 || p == 0; }),
                          options),
                HasSubstr("sensor \"k2\" does not see the wand's second position"));
    EXPECT_THAT(complaint(views_of(rig_of(3), kTwoPlaces,
                                   [](std::size_t s, std::size_t p) { return s != 2 || p == 1; }),
                          options),
                HasSubstr("sensor \"k3\" does not see the wand's first position"));
    EXPECT_THAT(complaint(views_of(rig_of(3), {kTwoPlaces[0]}, always), options),
                HasSubstr("at rest at fewer than two places"));
    EXPECT_THAT(complaint(views_of(rig_of(3), {kTwoPlaces[0], kTwoPlaces[0]}, always), options),
                HasSubstr("at rest at fewer than two places"));
    EXPECT_THAT(
        complaint(views_of(rig_of(3), {kTwoPlaces[0], kTwoPlaces[0] + Vector3d(0.2, 0.0, 0.0)}, always),
                  options),
        HasSubstr("0.20 m apart"));
  }
}

// A hand that drifts over 1 cm ends one rest and begins another; and one sensor alone may see an early rest.
TEST(CalibrateTwoPositions, ARestThatDriftedIsNoSecondPlace) {
  const auto rig = rig_of(3);
  const Calibration sound = calibrate_two_positions(views_of(rig, kTwoPlaces, always), "session.h5",
                                                    kCorrected, std::nullopt, kNoFloors);
  const std::vector<Vector3d> places{
      {0.4, 1.3, -0.2}, kTwoPlaces[0], kTwoPlaces[0] + Vector3d(0.0, 0.012, 0.0), kTwoPlaces[1]};
  const Calibration drifted = calibrate_two_positions(
      views_of(rig, places, [](std::size_t s, std::size_t p) { return p > 0 || s == 1; }), "session.h5",
      kCorrected, std::nullopt, kNoFloors);
  for (std::size_t s = 0; s < 3; ++s)
    expect_pose(drifted.sensors[s], sound.sensors[s].world_from_sensor, 1e-9, 1e-7);
}

}  // namespace
}  // namespace trilat
