// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/over_time.h"

#include <algorithm>
#include <atomic>
#include <mutex>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "pipeline/accuracy/accuracy_study.h"
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

}  // namespace
}  // namespace trilat
