// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

constexpr const char* kEverything = R"("alignments": ["mean", "rigid", "held_out", "joint_offset"],
    "occluded_apart": true, "clock": "motion", "methods": [
    {"method": "mean"}, {"method": "median"},
    {"method": "kalman"}, {"method": "rts"}, {"method": "window", "window_s": 1},
    {"method": "nonlinear"}, {"method": "newton"}, {"method": "single"},
    {"method": "nonlinear", "name": "printed", "occlusion": "printed"},
    {"method": "median", "name": "corrected", "occlusion": "corrected", "fewest_sensors": 2}])";

TEST(Determinism, ACampaignWithTrackersAndDepthGivesTheSameBytesForAnyNumberOfThreads) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(3, 1.0);
  spec.body_tracker = default_body_tracker();
  spec.depth.takes = true;
  const Campaign campaign = simulate_into(folder / "campaign", spec);
  const StudySpec study = study_of(kEverything);
  for (const int threads : {1, 2, 8})
    EXPECT_EQ(
        execute_study(study, campaign, folder / std::to_string(threads), {.threads = threads}).takes_failed,
        0u);
  for (const char* file :
       {"samples.h5", "summary.json", "tracking.json", "replay.h5", "simulator.json", "manifest.json"}) {
    const std::string one = read_file(folder / "1" / file);
    EXPECT_FALSE(one.empty()) << file;
    EXPECT_TRUE(one == read_file(folder / "2" / file)) << file;
    EXPECT_TRUE(one == read_file(folder / "8" / file)) << file;
  }
}

}  // namespace
}  // namespace trilat
