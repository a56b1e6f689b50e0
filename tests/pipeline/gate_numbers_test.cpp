// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/results/studies/sweep_summary.h"
#include "pipeline/gate/judge_numbers.h"
#include "pipeline/gate/number_meaning.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

Json document_with(double mae_m, double digits) {
  return {{"study", "sweep"},
          {"cells",
           {{{"method", "a"}, {"mae_m", mae_m}, {"mean_digits", 9.0}, {"mae_low_m", mae_m / 2.0}},
            {{"method", "b"}, {"mae_m", 0.1}, {"mean_digits", digits}, {"mae_low_m", 0.05}}}}};
}

TEST(GateNumbers, AreJudgedByTheirKeyAndSize) {
  NumberChanges changes = judge_numbers("sweep", document_with(0.11, 9.0), document_with(0.1, 9.0), {});
  EXPECT_EQ(changes.differing, 2u);  // the end of the interval too, which is not judged
  ASSERT_THAT(changes.findings, SizeIs(1));
  EXPECT_TRUE(changes.findings[0].alarm);
  EXPECT_NEAR(changes.findings[0].percent, 10.0, 1e-9);
  EXPECT_THAT(changes.findings[0].what, HasSubstr("/cells/0 [a]/mae_m"));
  changes = judge_numbers("sweep", document_with(0.09, 9.0), document_with(0.1, 9.0), {});
  ASSERT_THAT(changes.findings, SizeIs(1));
  EXPECT_FALSE(changes.findings[0].alarm);
  changes = judge_numbers("sweep", document_with(0.1, 8.0), document_with(0.1, 9.0), {});
  ASSERT_THAT(changes.findings, SizeIs(1));
  EXPECT_TRUE(changes.findings[0].alarm);  // fewer digits are worse
  EXPECT_THAT(judge_numbers("sweep", document_with(0.1005, 9.0), document_with(0.1, 9.0), {}).findings,
              IsEmpty());
}

TEST(GateNumbers, ANumberThatIsNoNumberAnyMoreIsAnAlarm) {
  Json now = document_with(0.1, 9.0);
  now["cells"][0]["mae_m"] = nullptr;
  const NumberChanges changes = judge_numbers("sweep", now, document_with(0.1, 9.0), {});
  ASSERT_THAT(changes.findings, SizeIs(1));
  EXPECT_TRUE(changes.findings[0].alarm);
  EXPECT_EQ(changes.findings[0].direction, Direction::worse);
}

TEST(GateNumbers, KeysOfRealSummariesMeanWhatTheyMean) {
  using enum NumberMeaning;
  const std::vector<std::pair<NumberMeaning, std::vector<const char*>>> keys{
      {less_is_worse,
       {"below_2ms", "answered", "asked", "coverage", "coverage_share", "mean_digits", "min_digits",
        "p50_digits", "pck_5cm_10cm_15cm", "within_bound_share", "within_limits_share",
        "corrected_coverage"}},
      {more_is_worse,
       {"mae_m",
        "axis_mae_m",
        "axis_mean_mae_m",
        "start_mae_m",
        "rmse_m",
        "best_rms",
        "rms_error_m",
        "median_m",
        "p05_m",
        "p25_m",
        "p75_m",
        "p90_m",
        "p95_m",
        "p99_s",
        "p999_s",
        "p50_iterations",
        "max_m",
        "max_iterations",
        "mean_iterations",
        "mean_gdop",
        "mean_error_m",
        "mpjpe_m",
        "pa_mpjpe_m",
        "jitter_m_s3",
        "bone_length_sd_m",
        "worst_m",
        "takes_failed",
        "failed_runs",
        "failed",
        "offset_sigma_s",
        "offset_bound_s",
        "rotation_max_rad",
        "depth_residual_m"}},
      {not_judged,
       {"below_2ms_low", "below_2ms_high", "coverage_low", "mae_low_m", "mae_high_m", "low_m", "high_m",
        "percent_low", "percent_high", "mae_standard_error_m", "clusters", "resamples", "sd_m", "statuses",
        "mpjpe_low_m", "ratio_high"}},
      {unknown, {"difference_m", "percent_of_reference", "seed", "trials", "n", "threshold", "x_m"}}};
  for (const auto& [meaning, list] : keys)
    for (const char* key : list) EXPECT_EQ(meaning_of_key(key), meaning) << key;
}

TEST(GateNumbers, AListThatLosesItsNumbersIsAnAlarm) {
  Json before{{"errors_m", Json::array()}}, now = before;
  for (int i = 0; i < 200; ++i) {
    before["errors_m"].push_back(0.05);
    now["errors_m"].push_back(i < 150 ? Json(0.05) : Json());
  }
  NumberChanges changes = judge_numbers("study", now, before, {});
  ASSERT_THAT(changes.findings, SizeIs(1));
  EXPECT_TRUE(changes.findings[0].alarm);
  EXPECT_NEAR(changes.findings[0].percent, -25.0, 1e-9);
  for (Json& x : now["errors_m"]) x = nullptr;
  changes = judge_numbers("study", now, before, {});
  ASSERT_THAT(changes.findings, SizeIs(1));
  EXPECT_TRUE(changes.findings[0].alarm);
}

TEST(GateNumbers, TheLargestChangeCountsListsToo) {
  Json before{{"errors_m", Json::array()}}, now = before;
  for (int i = 0; i < 200; ++i) {
    before["errors_m"].push_back(0.05);
    now["errors_m"].push_back(0.06);
  }
  EXPECT_NEAR(judge_numbers("study", now, before, {}).largest_percent, 20.0, 1e-9);
}

}  // namespace
}  // namespace trilat
