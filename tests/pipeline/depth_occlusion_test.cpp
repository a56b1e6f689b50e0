// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/depth_occlusion.h"

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/results/studies/tracking_summary.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/rewritten_session.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

constexpr const char* kByDepth =
    R"("alignments": ["none"],
       "methods": [{"method": "mean", "occlusion": "depth", "inferred_is_occluded": false}])";

struct Watched {
  ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", spec());
  static SimulationSpec spec() {
    SimulationSpec spec = walking_spec(1, 0.6);
    spec.body_tracker = exact_body_tracker();
    spec.depth.takes = true;
    return spec;
  }
  ResultsSummary evaluated(const std::function<bool(std::size_t, std::uint64_t)>& keeps) {
    Campaign changed = campaign;
    SessionChange change;
    change.keeps_depth = keeps;
    change_session(changed.takes[0], folder / "changed.h5", change);
    return execute_study(study_of(kByDepth), changed, folder / "results", {});
  }
  std::uint64_t rejected() {
    const auto tracking = read_beside<TrackingSummary>(folder / "results");
    std::uint64_t count = 0;
    for (const ViewRow& row : tracking->views)
      if (row.rule == "hidden in depth") count += row.rejected;
    return count;
  }
};

TEST(DepthOcclusion, ASensorWithoutDepthIsNamedThoughAnotherHasIt) {
  Watched watched;
  const ResultsSummary summary =
      watched.evaluated([](std::size_t sensor, std::uint64_t) { return sensor == 0; });
  EXPECT_EQ(summary.takes_failed, 1u);
  ASSERT_FALSE(summary.notes.empty());
  EXPECT_THAT(summary.notes.front().place, HasSubstr("changed.h5:/sensors/k2"));
  EXPECT_THAT(summary.notes.front().text, HasSubstr("holds no depth frames"));
}

TEST(DepthOcclusion, WhereFramesAreMissingNothingIsHidden) {
  Watched watched;
  EXPECT_EQ(watched.evaluated([](std::size_t, std::uint64_t) { return true; }).takes_failed, 0u);
  const std::uint64_t all = watched.rejected();
  const ResultsSummary some =
      watched.evaluated([](std::size_t, std::uint64_t frame) { return frame < 4 || frame > 12; });
  EXPECT_EQ(some.takes_failed, 0u);
  EXPECT_LT(watched.rejected(), all);
  EXPECT_GT(watched.rejected(), 0u);
  EXPECT_GT(find_cell(some, "mean", "walking", "head", "none")->coverage(), 0.9);
  EXPECT_EQ(watched.evaluated([](std::size_t, std::uint64_t frame) { return frame == 0; }).takes_failed, 0u);
  EXPECT_LT(watched.rejected() * 8, all);
}

}  // namespace
}  // namespace trilat
