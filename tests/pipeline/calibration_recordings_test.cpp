// SPDX-License-Identifier: MIT
#include "pipeline/simulate/calibration_recordings.h"

#include <atomic>
#include <cmath>

#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/rig/depth_rays.h"
#include "datasets/session/clock/session_clock.h"
#include "datasets/session/session_reader.h"
#include "tests/pipeline/campaigns.h"
#include "tests/support/scratch.h"
#include "tests/support/whole_take.h"

namespace trilat {
namespace {

SimulationSpec wand_spec(std::uint64_t positions) {
  SimulationSpec spec = walking_spec(1, 0.2);
  spec.wand = WandSpec{};
  spec.wand->motion = {positions, 0.3, 0.3};
  return spec;
}

TEST(SimulateWand, WithoutDepthAndWandACampaignHasNeither) {
  const ScratchFolder folder;
  simulate_into(folder / "campaign", walking_spec(1));
  EXPECT_FALSE(std::filesystem::exists(folder / "campaign/wand"));
  const SessionReader session(folder / "campaign/p01-walking/session.h5");
  EXPECT_FALSE(session.header().sensors[0].has_depth);
  EXPECT_THAT(read_file(folder / "campaign/p01-walking/truth.json"),
              testing::Not(testing::HasSubstr("depth")));
}

// The sensors' depth at the projection of the true ball is its near side, but for half a pixel.
TEST(SimulateWand, TheBallIsInTheDepthFramesWhereTheTruthSays) {
  const ScratchFolder folder;
  SimulationSpec spec = wand_spec(5);
  spec.sensor.free_running = false;
  spec.sensor.dropped_share = 0.0;
  spec.depth.noise = noise_free_depth();
  spec.wand->person = false;
  simulate_into(folder / "c", spec);
  const Json truth = read_json(folder / "c/wand/truth.json");
  const auto poses = read_calibration(folder / "c/calibration.json").sensors;
  const SessionReader session(folder / "c/wand/session.h5");
  ASSERT_EQ(truth["positions"].size(), 5u);
  EXPECT_EQ(truth["ball_radius_m"], 0.075);
  std::vector<std::uint16_t> depth(kDepthPixels);
  int seen = 0;
  for (const Json& position : truth["positions"]) {
    const auto p = position["position_m"].get<std::vector<double>>();
    const double middle_s =
        1e-9 * (0.5 * (position["from_host_ns"].get<double>() + position["to_host_ns"].get<double>()) -
                static_cast<double>(kMotionStart.ns));
    for (std::size_t s = 0; s < poses.size(); ++s) {
      const Eigen::Vector3d ball = poses[s].world_from_sensor.inverse() * Eigen::Vector3d(p[0], p[1], p[2]);
      const auto pixel = project(session.header().sensors[s].intrinsics, ball);
      if (!pixel || pixel->x() < 5.0 || pixel->x() > 506.0 || pixel->y() < 5.0 || pixel->y() > 418.0)
        continue;
      session.depth_frame(s, static_cast<std::uint64_t>(std::lround(middle_s * 30.0)), depth);
      const DepthImageView image{kDepthWidth, kDepthHeight, depth};
      const double near_m = ball.z() * (1.0 - 0.075 / ball.norm());
      EXPECT_NEAR(1e-3 * image.at_mm(static_cast<int>(std::lround(pixel->x())),
                                     static_cast<int>(std::lround(pixel->y()))),
                  near_m, 0.004)
          << s << " at " << middle_s << " s";
      ++seen;
    }
  }
  EXPECT_GE(seen, 15);
}

TEST(SimulateWand, TheMocapHasARigidBodyInTheBallsCentre) {
  const ScratchFolder folder;
  SimulationSpec spec = wand_spec(4);
  spec.mocap.gap_share = 0.0;
  simulate_into(folder / "c", spec);
  const WholeTake take = whole_take(folder / "c/wand/mocap.csv");
  const std::size_t wand = find_asset(take.header, "rigid_body:wand", "mocap.csv");
  const Json truth = read_json(folder / "c/wand/truth.json");
  for (const Json& position : truth["positions"]) {
    const auto p = position["position_m"].get<std::vector<double>>();
    const double start_s =
        1e-9 * (position["from_host_ns"].get<double>() - static_cast<double>(kMotionStart.ns));
    const auto frame = static_cast<std::size_t>(std::lround((start_s + 0.1) * spec.mocap.rate_hz));
    EXPECT_LT((take.frames.at(frame).poses[wand].position_m - Eigen::Vector3d(p[0], p[1], p[2])).norm(),
              0.002);
  }
  const Json& sensor = truth["sensors"][2];
  EXPECT_EQ(sensor["depth_offset_m"], draw_depth_unit({}, spec.seed, 2).offset_m);
  EXPECT_LE((wand_mocap_start(spec) - kMotionStart).seconds(), 0.005);
  EXPECT_EQ((wand_mocap_start(spec) - kMotionStart).ns, truth["stated_minus_true_mocap_start_ns"]);
}

TEST(SimulateWand, TakesHaveDepthWhenAskedForAndTheSameBodies) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(1, 0.5);
  simulate_into(folder / "without", spec);
  spec.depth.takes = true;
  simulate_into(folder / "with", spec);
  const SessionReader without(folder / "without/p01-walking/session.h5");
  const SessionReader with(folder / "with/p01-walking/session.h5");
  for (std::size_t s = 0; s < 4; ++s) {
    const std::uint64_t frames = with.counts(s).body_frames;
    EXPECT_EQ(with.counts(s).depth_frames, frames);
    ASSERT_EQ(without.counts(s).body_frames, frames);
    EXPECT_EQ(with.body_frames(s, frames - 1, 1).at(0).bodies.at(0).position_m,
              without.body_frames(s, frames - 1, 1).at(0).bodies.at(0).position_m);
  }
  EXPECT_THAT(read_file(folder / "with/p01-walking/truth.json"),
              testing::HasSubstr("depth_wiggle_phase_rad"));
}

}  // namespace
}  // namespace trilat
