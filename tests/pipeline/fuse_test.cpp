// SPDX-License-Identifier: MIT
// `trilat fuse`: joints of all sensors together, without ground truth.
#include <cmath>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/rig/campaign.h"
#include "pipeline/accuracy/fuse_session.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

MethodSpec method_named(const std::string& name) {
  return read_as<MethodSpec>(Json{{"method", name}}, {"method", {}});
}

std::size_t index_of(const FusedSession& path, Joint joint) {
  return static_cast<std::size_t>(std::ranges::find(path.joints, joint) - path.joints.begin());
}

TEST(Fuse, ExactSensorsGiveOnePersonWhateverTheMethod) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder.path() / "campaign", without_noise(walking_spec(1)));
  const Take& take = campaign.takes[0];
  const FusedSession mean = fuse_session(take.session, take.calibration, method_named("mean"), 30.0, {});
  ASSERT_EQ(mean.joints.size(), std::size_t{kJointCount});
  for (const char* name : {"nonlinear", "range_bearing", "rts"}) {
    const FusedSession other = fuse_session(take.session, take.calibration, method_named(name), 30.0, {});
    ASSERT_EQ(other.points.size(), mean.points.size()) << name;
    EXPECT_GT(other.answered, 0.9) << name;
    double largest_m = 0.0;
    for (std::size_t k = 0; k < mean.points.size(); ++k)
      if (is_usable(mean.points[k].status) && is_usable(other.points[k].status))
        largest_m = std::max(largest_m, (mean.points[k].position_m - other.points[k].position_m).norm());
    EXPECT_LT(largest_m, 0.02) << name;
  }
  const std::size_t head = index_of(mean, Joint::head), foot = index_of(mean, Joint::foot_left);
  EXPECT_GT(mean.points[head].position_m.y(), mean.points[foot].position_m.y() + 1.0);
}

TEST(Fuse, TheProgramWritesMarkersAndTablesAndRefusesOtherNames) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder.path() / "campaign", walking_spec(1));
  const std::string session = campaign.takes[0].session.string();
  const std::string calibration = campaign.takes[0].calibration.string();
  const std::string campaign_sensor = "k2";
  const std::string trc = (folder.path() / "walk.trc").string(), csv = (folder.path() / "walk.csv").string();
  const Ended markers =
      run_trilat(folder, {"fuse", session, "--calibration", calibration, "-o", trc, "--rate-hz", "15"});
  EXPECT_EQ(markers.code, 0) << markers.err;
  EXPECT_THAT(markers.out, HasSubstr("cm along their rays and"));
  EXPECT_THAT(markers.out, HasSubstr("k2, beside its calibration: turned by 0."));
  EXPECT_THAT(read_file(trc), HasSubstr("15\t15\t"));
  EXPECT_THAT(read_file(trc), HasSubstr("Frame#\tTime\tspine_base\t"));
  EXPECT_EQ(run_trilat(folder, {"fuse", session, "--calibration", calibration, "-o", csv}).code, 0);
  EXPECT_THAT(read_file(csv), HasSubstr("head,converged,"));
  EXPECT_THAT(run_trilat(folder, {"info", trc}).out, HasSubstr("spine_base"));
  const auto refused = [&](std::vector<std::string> more, const char* message) {
    std::vector<std::string> arguments{"fuse", session, "--calibration", calibration};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_refused(run_trilat(folder, arguments), message);
  };
  refused({"-o", "walk.bvh"}, "must end in .trc or .csv");
  refused({"-o", csv, "--method", "psychic"}, "allowed: linear");
  refused({"-o", csv, "--sensor", "k1"}, "--sensor: is for --method single; range_bearing uses all sensors");
  EXPECT_THAT(run_trilat(folder, {"fuse", session, "--calibration", calibration, "-o", csv, "--force",
                                  "--method", "single", "--sensor", campaign_sensor, "--json"})
                  .out,
              HasSubstr("\"sensors\": [\n    \"" + campaign_sensor + "\"\n  ]"));
  refused({"-o", session}, "must end in .trc or .csv");
  refused({"-o", csv}, "walk.csv: exists. Choose another name");
  expect_refused(run_trilat(folder, {"fuse", "absent.h5", "--calibration", calibration, "-o", "new.trc"}),
                 "absent.h5");
}

// A sensor that was turned by 4 degrees since it was calibrated is turned back, and the rest stays.
TEST(Fuse, ACalibrationIsCorrectedByTheBodies) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", walking_spec(1, 8.0));
  const Take& take = campaign.takes[0];
  const Calibration truth = read_calibration(take.calibration);
  Calibration stated = truth;
  RigidTransform& pose = stated.sensors[1].world_from_sensor;
  pose.rotation = Eigen::AngleAxisd(0.07, Eigen::Vector3d::UnitY()) * pose.rotation;
  stated.sensors.push_back(truth.sensors[0]);
  stated.sensors.back().name = "elsewhere";
  stated.sensors.back().world_from_sensor.translation_m.x() += 5.0;
  write_calibration(folder / "stated.json", stated);
  const Ended ended =
      run_trilat(folder, {"calibrate", take.session.string(), "--method", "bodies", "--from",
                          (folder / "stated.json").string(), "-o", (folder / "new.json").string()});
  expect_refused(run_trilat(folder, {"calibrate", take.session.string(), "--method", "bodies", "--from",
                                     (folder / "stated.json").string(), "-o",
                                     (folder / "stated.json").string(), "--force"}),
                 "stated.json");
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("k2, beside its calibration: turned by "));
  const Calibration corrected = read_calibration(folder / "new.json");
  EXPECT_EQ(corrected.method, "corrected by bodies");
  EXPECT_EQ(corrected.sources.size(), 2u);
  ASSERT_EQ(corrected.sensors.size(), stated.sensors.size());
  EXPECT_EQ(corrected.sensors.back().world_from_sensor.translation_m,
            stated.sensors.back().world_from_sensor.translation_m);
  EXPECT_FALSE(corrected.sensors.back().covariance.has_value());
  for (std::size_t s = 0; s < truth.sensors.size(); ++s) {
    const RigidTransform &is = corrected.sensors[s].world_from_sensor,
                         &was = truth.sensors[s].world_from_sensor;
    EXPECT_LT(is.rotation.angularDistance(was.rotation), 0.025) << s;
    EXPECT_LT((is.translation_m - was.translation_m).norm(), 0.03) << s;
    EXPECT_TRUE(corrected.sensors[s].covariance.has_value());
    EXPECT_GT(corrected.sensors[s].used, 0u);
    EXPECT_LE(corrected.sensors[s].used, corrected.positions);
    EXPECT_GT(corrected.sensors[s].residual_rms_m, 0.005);
    EXPECT_LT(corrected.sensors[s].residual_rms_m, 0.2);
  }
  expect_refused(run_trilat(folder, {"calibrate", take.session.string(), "--from", "x.json", "-o", "y.json"}),
                 "--from: is of no use with --method wand");
}

}  // namespace
}  // namespace trilat
