// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numeric>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/methods/method.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/error_cells.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

const std::string kOverTime = R"("alignments": ["none"], "methods": [{"method": "mean"}, {"method": "rts"},
    {"method": "window", "occlusion": "corrected"}, {"method": "window", "name": "stiff", "bone_sigma_m": 0.003}])";

double mean_error_m(const ResultsSummary& summary, const std::string& method) {
  double sum_m = 0.0, count = 0.0;
  for (const ErrorCell& cell : error_cells(summary)) {
    if (cell.method != method) continue;
    EXPECT_GT(cell.coverage(), 0.95) << method << " " << cell.group;
    sum_m += cell.mae_m;
    ++count;
  }
  EXPECT_GT(count, 0.0) << method;
  return sum_m / count;
}

TEST(OverTime, AllJointsTogetherAreAsGoodAsTheMean) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", walking_spec(2));
  const StudySpec study = study_of(kOverTime);
  const ResultsSummary summary = execute_study(study, campaign, folder / "results", {});
  for (const char* method : {"window", "stiff"})
    EXPECT_LT(mean_error_m(summary, method), 1.1 * mean_error_m(summary, "mean")) << method;
}

// Without errors of the sensors; what is left is what smoothing takes away.
TEST(OverTime, WithoutNoiseAllJointsTogetherFindTheTruth) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", synchronised(without_noise(walking_spec(1))));
  const StudySpec study = study_of(
      R"("alignments": ["none"], "methods": [{"method": "window", "sigma_m": 1e-4, "loss_scale_m": 1}])");
  EXPECT_LT(mean_error_m(execute_study(study, campaign, folder / "results", {}), "window"), 0.001);
}

// Two joints of a walk, seen by one sensor; a bone joins them.
TEST(OverTime, AllJointsTogetherSayHowFarTheyAre) {
  constexpr std::size_t kWalkInstants = 3000;
  std::vector<std::int64_t> time_ns;
  for (std::size_t i = 0; i < kWalkInstants; ++i)
    time_ns.push_back(static_cast<std::int64_t>(i) * 33'333'333);
  const std::array joints{Joint::elbow_left, Joint::wrist_left};
  const TrajectoryInput seen{
      time_ns, 1, joints, [&](std::size_t instant, Joint joint, std::span<JointObservation> observations) {
        const double s = static_cast<double>(instant) / 30.0;
        observations[0].seen = true;
        observations[0].state = TrackingState::tracked;
        observations[0].point_in_world_m = {std::sin(s), joint == joints[0] ? 1.0 : 1.3, 0.0};
      }};
  std::vector<std::size_t> advanced;
  MethodTrajectories paths{0, joints.size(), std::vector<TrajectoryPoint>(kWalkInstants * joints.size())};
  solve_bones({}, seen, {[&](std::size_t instants) { advanced.push_back(instants); }, {}}, paths);
  EXPECT_GT(advanced.size(), 3u);
  EXPECT_EQ(std::accumulate(advanced.begin(), advanced.end(), std::size_t{0}), kWalkInstants);
  EXPECT_THROW(solve_bones({}, seen, {{}, [] { return true; }}, paths), Interrupted);
}

}  // namespace
}  // namespace trilat
