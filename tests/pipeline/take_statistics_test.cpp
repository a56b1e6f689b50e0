// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/take_statistics.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "pipeline/accuracy/accuracy_study.h"
#include "tests/pipeline/campaigns.h"

namespace trilat {
namespace {

// Every sample that has a speed is in one half, the halves are about equal, and what is faster is in the
// faster.
TEST(TakeStatistics, SamplesAreHalvedByTheSpeedOfTheirJoint) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", walking_spec(1));
  const StudySpec study = study_of(
      R"("occluded_apart": true, "alignments": ["rigid"], "methods": [{"method": "mean"}, {"method": "single"}])");
  const Plan plan = make_plan(study, campaign);
  const StatisticsLayout layout = statistics_layout(plan);
  execute_study(study, campaign, folder / "results", {});
  const SamplesFile samples = SamplesFile::open(folder / "results/samples.h5");
  const TakeSummary summary = summarise_take(samples, 0, layout);
  const std::uint64_t instants = plan.takes[0].instants;
  const SampleBlock block = samples.read(0, 0, instants);
  const SampleView view{block, layout.axes};
  const AlignmentTable& rigid = summary.alignments[0];
  for (std::size_t j = 0; j < layout.axes.joints; ++j)
    for (std::size_t m = 0; m < layout.axes.methods; ++m) {
      std::vector<std::pair<double, double>> all;  // speed, error
      for (std::uint64_t i = 1; i + 1 < instants; ++i) {
        const AlignedError e = error_of(view, i, j, m, view.slot(i, j, m), rigid);
        const Eigen::Vector3d way_m = view.truth(i + 1, j) - view.truth(i - 1, j);
        if (is_usable(e.status) && way_m.allFinite())
          all.emplace_back(way_m.norm() * layout.rate_hz / 2.0, e.error_m.norm());
      }
      std::ranges::sort(all);
      const JointSums& sums = summary.statistics.of_joint[j * layout.axes.methods + m];
      ASSERT_EQ(sums.slow_m.n + sums.fast_m.n, all.size());
      double slow_m = 0.0, fast_m = 0.0;
      for (std::size_t k = 0; k < all.size(); ++k) (k < sums.slow_m.n ? slow_m : fast_m) += all[k].second;
      EXPECT_NEAR(sums.slow_m.sum, slow_m, 1e-9);
      EXPECT_NEAR(sums.fast_m.sum, fast_m, 1e-9);
      EXPECT_GE(2 * sums.slow_m.n, all.size());
      EXPECT_LE(sums.slow_m.n, all.size() * 3 / 4);  // speeds are told apart to 2 cm/s
    }
}

}  // namespace
}  // namespace trilat
