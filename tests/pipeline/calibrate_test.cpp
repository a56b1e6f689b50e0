// SPDX-License-Identifier: MIT
// From depth frames, tracked bodies and hand-made sightings to sensor poses.
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/base/units.h"
#include "datasets/results/summary.h"
#include "datasets/session/session_writer.h"
#include "pipeline/calibration/calibrate_bodies.h"
#include "pipeline/calibration/calibrate_wand.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/error_cells.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/wand_sessions.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

RigidTransform wand_from_world(const std::vector<Vector3d>& places) {
  Eigen::Matrix3d axes;
  axes.row(0) = (places[1] - places[0]).normalized();
  axes.row(2) = (places[1] - places[0]).cross(places[2] - places[0]).normalized();
  axes.row(1) = axes.row(2).cross(axes.row(0));
  const Eigen::Quaterniond rotation(axes);
  return {rotation, -(rotation * places[0])};
}

void expect_pose(const SensorPose& pose, const RigidTransform& truth, double limit_m, double limit_deg) {
  EXPECT_LT((pose.world_from_sensor.translation_m - truth.translation_m).norm(), limit_m) << pose.name;
  EXPECT_LT(pose.world_from_sensor.rotation.angularDistance(truth.rotation), limit_deg * kRadPerDegree)
      << pose.name;
}

// What sensors without an error would have seen of the ball at rest.
WandObservations views_of(const std::vector<RigidTransform>& rig, const std::vector<Vector3d>& places,
                          const std::function<bool(std::size_t sensor, std::size_t place)>& sees) {
  WandObservations views;
  for (std::size_t s = 0; s < rig.size(); ++s)
    views.evidence.push_back(
        {.name = name_of_sensor(s), .frames = 90, .statuses = {{"found", 60}, {"no_wand", 30}}});
  for (std::size_t p = 0; p < places.size(); ++p) {
    WandPosition position;
    position.first = HostTime{kStart_ns + static_cast<std::int64_t>(p) * kPlaceEvery_ns};
    position.last = position.first + Duration{800'000'000};
    for (std::size_t s = 0; s < rig.size(); ++s)
      if (sees(s, p)) {
        StaticSighting ball;
        ball.sensor = s;
        ball.first = position.first;
        ball.last = position.last;
        ball.centre_in_sensor_m = rig[s].inverse() * places[p];
        ball.covariance_m2 = 1e-8 * Eigen::Matrix3d::Identity();
        ball.frames_used = 24;
        position.seen.push_back(ball);
        ++views.evidence[s].rests;
      }
    views.positions.push_back(position);
  }
  views.positions_of_first = views.positions.size();
  return views;
}

bool always(std::size_t, std::size_t) { return true; }

std::string complaint_about(WandObservations views, const CalibrateWandOptions& options = {}) {
  return message_of([&] { calibrate_views(std::move(views), "session.h5", options); });
}

TEST(CalibrateWand, ARecordingOfTwoSensorsGivesTheirPoses) {
  const ScratchFolder folder;
  const auto rig = rig_of(2);
  record_wand(folder / "session.h5", rig);
  const WandCalibration result = calibrate_wand({folder / "session.h5"}, {});
  ASSERT_EQ(result.views.positions.size(), kPlaces.size());
  ASSERT_EQ(result.calibration.sensors.size(), 2u);
  EXPECT_EQ(result.calibration.method, "wand");
  EXPECT_EQ(result.calibration.world, "wand");
  const RigidTransform wand = wand_from_world(kPlaces);
  for (std::size_t s = 0; s < 2; ++s) {
    const SensorPose& pose = result.calibration.sensors[s];
    expect_pose(pose, wand * rig[s], 0.005, 0.3);
    EXPECT_EQ(pose.used, kPlaces.size());
    EXPECT_TRUE(pose.covariance);
    EXPECT_EQ(result.views.evidence[s].frames, kPlaces.size() * kFramesOfPlace);
    EXPECT_EQ(result.views.evidence[s].statuses.at("found"), kPlaces.size() * kFramesOfPlace);
  }
  for (std::size_t p = 0; p < kPlaces.size(); ++p)
    EXPECT_LT((result.position_in_world_m[p] - wand * kPlaces[p]).norm(), 0.005) << p;
  ASSERT_EQ(result.calibration.sources.size(), 1u);
  EXPECT_EQ(result.calibration.sources[0].file, "session.h5");
}

TEST(CalibrateVerb, WritesACalibrationThatReadsBack) {
  const ScratchFolder folder;
  const auto rig = rig_of(2);
  record_wand(folder / "session.h5", rig);
  const std::string session = folder / "session.h5", output = folder / "calibration.json";
  const Ended text = run_trilat(folder, {"calibrate", session, "-o", output});
  EXPECT_EQ(text.code, 0) << text.err;
  EXPECT_THAT(text.out, AllOf(HasSubstr("| k1 "), HasSubstr("| k2 "), HasSubstr("calibration: " + output)));
  EXPECT_THAT(text.out + text.err, Not(HasSubstr("times what noise explains")));
  const Calibration first = read_calibration(output);
  const Ended json =
      run_trilat(folder, {"calibrate", session, "-o", output, "--force", "--json", "--threads", "1"});
  EXPECT_EQ(json.code, 0) << json.err;
  const Calibration again = read_calibration(output);
  EXPECT_EQ(only_json(json)["sensors"].size(), 2u);
  EXPECT_EQ(only_json(json)["calibration"], output);
  EXPECT_FALSE(only_json(json)["look_at"].empty());  // eight positions are few
  const RigidTransform wand = wand_from_world(kPlaces);
  for (std::size_t s = 0; s < 2; ++s) {
    expect_pose(pose_of(first, name_of_sensor(s), "here"), wand * rig[s], 0.005, 0.3);
    expect_pose(again.sensors[s], first.sensors[s].world_from_sensor, 1e-9, 1e-5);
    EXPECT_TRUE(again.sensors[s].covariance->isApprox(*first.sensors[s].covariance, 1e-6));
  }
}

TEST(CalibrateWand, ASessionWithoutDepthSaysWhatNeedsNone) {
  const ScratchFolder folder;
  SessionWriter(folder / "session.h5", header_of(2, false)).finish();
  EXPECT_THAT(message_of([&] { calibrate_wand({folder / "session.h5"}, {}); }),
              HasSubstr("session.h5:/sensors/k1: has no depth frames, in which the wand could be found; "
                        "`--method bodies` needs none"));
  EXPECT_THAT(message_of([&] { calibrate_bodies(folder / "session.h5", {}); }),
              HasSubstr("session.h5:/sensors/k1: has no body frames"));
}

std::string complaint_about_scene(const DepthScene& scene) {
  const ScratchFolder folder;
  record(folder / "session.h5", rig_of(2), {scene}, header_of(2));
  return message_of([&] { calibrate_wand({folder / "session.h5"}, {}); });
}

TEST(CalibrateWand, ASensorThatNeverSeesTheWandIsNamedWithItsCounts) {
  DepthScene scene;
  append_room(scene, {}, {0.0, 1.0, 0.0});
  EXPECT_THAT(complaint_about_scene(scene),
              AllOf(HasSubstr("sensor \"k1\" never sees the ball"), HasSubstr("(20 frames: no_wand 20)")));
}

TEST(CalibrateWand, TwoBallsAreSaidToBeTwo) {
  DepthScene scene = ball_in_room({-0.3, 1.0, -0.3});
  append_wand(scene, {0.3, 1.2, 0.3}, -Vector3d::UnitY(), {});
  EXPECT_THAT(complaint_about_scene(scene),
              AllOf(HasSubstr("sensor \"k1\" sees more than one ball"), HasSubstr("several_candidates")));
}

TEST(CalibrateWand, ABallAsLargeAsAHeadIsNotTheWand) {
  EXPECT_THAT(complaint_about_scene(ball_in_room({0.0, 1.0, 0.0}, 0.12)),
              AllOf(HasSubstr("sensor \"k1\" never sees the ball"), HasSubstr("is the radius right")));
}

// A diameter that was taken for a radius, and the reverse.
TEST(CalibrateWand, ABallOfHalfOrTwiceTheStatedRadiusIsNamed) {
  for (const double radius_m : {0.15, 0.0375})
    EXPECT_THAT(
        complaint_about_scene(ball_in_room({0.0, 1.0, 0.0}, radius_m)),
        HasSubstr(fmt::format("sensor \"k1\" sees a ball of {:g} m radius, and none of the stated one: "
                              "state --ball-radius-m {:g}",
                              radius_m, radius_m)));
}

TEST(CalibrateWand, ABallThatIsNeverStillForHalfASecondIsSaidToBe) {
  const ScratchFolder folder;
  record(folder / "session.h5", rig_of(2), {ball_in_room(kPlaces[0]), ball_in_room(kPlaces[1])}, header_of(2),
         10);
  EXPECT_THAT(
      message_of([&] { calibrate_wand({folder / "session.h5"}, {}); }),
      AllOf(HasSubstr("sensor \"k1\" never sees the ball at rest for half a second"), HasSubstr("found 20")));
}

TEST(CalibrateWand, TwoRecordingsMustBeOfOneRig) {
  const ScratchFolder folder;
  const DepthScene scene = ball_in_room(kPlaces[0]);
  record(folder / "a.h5", rig_of(1), {scene}, header_of(1), 2);
  SessionHeader other = header_of(1);
  other.sensors[0].name = "left";
  record(folder / "b.h5", rig_of(1), {scene}, other, 2);
  record(folder / "c.h5", rig_of(2), {scene}, header_of(2), 2);
  for (const char* second : {"b.h5", "c.h5"})
    EXPECT_THAT(message_of([&] {
                  calibrate_wand({folder / "a.h5", folder / second}, {});
                }),
                AllOf(HasSubstr(second), HasSubstr("has other sensors than the first session")));
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

// The wand's own frame is turned and shifted into the export's by two positions, too.
TEST(CalibrateWandVerb, PosesFromTwoPositionsAreTiedToTheExport) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(1, 0.2);
  spec.wand = WandSpec{};
  spec.wand->motion = {4, 0.6, 0.3};
  const Campaign campaign = simulate_into(folder / "c", spec);
  const std::vector<std::string> by_two{"calibrate", folder / "c/wand/session.h5", "--method",
                                        "two_positions", "-o"};
  auto tied = by_two, free = by_two;
  free.push_back(folder / "free.json");
  tied.insert(tied.end(), {folder / "tied.json", "--mocap", folder / "c/wand/mocap.csv", "--asset", "wand",
                           "--mocap-start-host-ns",
                           std::to_string(read_campaign(folder / "c").wand->mocap_start_host_ns)});
  EXPECT_EQ(run_trilat(folder, free).code, 0);
  EXPECT_EQ(run_trilat(folder, tied).code, 0);
  const Calibration in_wand = read_calibration(folder / "free.json");
  const Calibration in_world = read_calibration(folder / "tied.json");
  const Calibration truth = read_calibration(folder / "c/calibration.json");
  EXPECT_EQ(in_wand.world, "wand");
  EXPECT_EQ(in_world.world, "optitrack");
  for (std::size_t s = 0; s < truth.sensors.size(); ++s) {
    EXPECT_GT((in_wand.sensors[s].world_from_sensor.translation_m -
               truth.sensors[s].world_from_sensor.translation_m)
                  .norm(),
              0.3);
    expect_pose(in_world.sensors[s], truth.sensors[s].world_from_sensor, 0.08, 3.0);
  }
}

// The paper's axis of the trajectory is y; --trajectory-axis names another.
TEST(CalibrateWandVerb, TheTrajectorysAxisIsTheOneThatIsNamed) {
  const ScratchFolder folder;
  record_wand(folder / "wand.h5", rig_of(2));
  const auto calibrated = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"calibrate", folder / "wand.h5", "--method",
                                   "printed",   "--movement-m",     "0.7",
                                   "-o",        folder / "c.json",  "--force"};
    words.insert(words.end(), more.begin(), more.end());
    const Ended ended = run_trilat(folder, words);
    EXPECT_NE(ended.code, 2) << ended.err;
    Json sensors = read_json(folder / "c.json").at("sensors");
    return sensors.dump();
  };
  const std::string as_printed = calibrated({}), y = calibrated({"--trajectory-axis", "y"}),
                    x = calibrated({"--trajectory-axis", "x"});
  EXPECT_EQ(as_printed, y);
  EXPECT_NE(x, y);
}

// Four samples 0.3 mm to one side and the other along x: squares of 0.36 mm2 in all, of the mean an axis 0.36
// / (3 axes * 3 * 4 samples) = 0.01 mm2.
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

// Of each sensor one body frame.
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

TEST(RunVerbCalibration, TheCalibrationNamedOnTheCommandLineIsUsed) {
  const ScratchFolder folder;
  const std::string campaign = folder / "campaign";
  simulate_into(campaign, synchronised(without_noise(walking_spec(1))));
  const std::string study = file_with(folder, "study.json",
                                      R"({"format": "trilat.study", "version": 1, "kind": "accuracy",
      "name": "test", "alignments": ["none"], "methods": [{"method": "mean"}, {"method": "nonlinear"}]})");
  Calibration calibration = read_calibration(folder / "campaign/calibration.json");
  for (SensorPose& pose : calibration.sensors) pose.world_from_sensor.translation_m.x() += 1.0;
  write_calibration(folder / "shifted.json", calibration);
  const auto rmse_m = [&](const std::vector<std::string>& more, const char* method) {
    std::vector<std::string> arguments{"run",   study, "--campaign", campaign, "-o", folder / "results",
                                       "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ended ended = run_trilat(folder, arguments);
    EXPECT_EQ(ended.code, 0) << ended.err;
    const ResultsSummary summary = read_results<ResultsSummary>(folder / "results");
    const auto cell = find_cell(summary, method, "walking", "shoulder", "none");
    return cell ? cell->rmse_m : std::nan("");
  };
  for (const char* method : {"mean", "nonlinear"}) {
    EXPECT_LT(rmse_m({}, method), 1e-4);
    EXPECT_NEAR(rmse_m({"--calibration", folder / "shifted.json"}, method), 1.0, 1e-3);
  }
  write_file(folder / "bad.json", R"({"format": "trilat.calibration", "version": 1, "method": "wand",
      "sensors": []})");
  for (const char* bad : {"bad.json", "absent.json"})
    expect_refused(run_trilat(folder, {"run", study, "--campaign", campaign, "-o", folder / "other",
                                       "--calibration", folder / bad}),
                   bad);
  EXPECT_FALSE(std::filesystem::exists(folder / "other"));
}

}  // namespace
}  // namespace trilat
