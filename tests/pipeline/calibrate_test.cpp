// SPDX-License-Identifier: MIT
// From depth frames and tracked bodies to sensor poses, by the program too.
#include "datasets/base/files.h"
#include "datasets/results/summary.h"
#include "pipeline/calibration/calibrate_bodies.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/error_cells.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/wand_views.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string complaint_about_scene(const DepthScene& scene) {
  const ScratchFolder folder;
  record(folder / "session.h5", rig_of(2), {scene}, header_of(2));
  return message_of([&] { calibrate_wand({folder / "session.h5"}, {}); });
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

TEST(CalibrateWand, ASessionWithoutDepthSaysWhatNeedsNone) {
  const ScratchFolder folder;
  SessionWriter(folder / "session.h5", header_of(2, false)).finish();
  EXPECT_THAT(message_of([&] { calibrate_wand({folder / "session.h5"}, {}); }),
              HasSubstr("session.h5:/sensors/k1: has no depth frames, in which the wand could be found; "
                        "`--method bodies` needs none"));
  EXPECT_THAT(message_of([&] { calibrate_bodies(folder / "session.h5", {}); }),
              HasSubstr("session.h5:/sensors/k1: has no body frames"));
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

}  // namespace
}  // namespace trilat
