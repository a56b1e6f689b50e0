// SPDX-License-Identifier: MIT
// How often intervals hold the truth, and the set that is not told apart from the best the best, of 2000 made
// campaigns each: docs/explanation/intervals.md has the counts.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "datasets/base/philox.h"
#include "evaluators/metrics/statistics.h"
#include "tests/support/trials.h"

namespace trilat {
namespace {

constexpr double kTruth_m = 0.08;

// One campaign's own random numbers.
class CampaignDraws {
 public:
  explicit CampaignDraws(std::uint64_t campaign) : stream_{47, Purpose::test, campaign} {}
  double uniform() { return stream_.uniform(next_++); }
  double normal() { return stream_.normal(next_++); }
  // Of mean 0 and standard deviation 1; skewed: gamma of shape 2.
  double error(bool skewed) {
    if (!skewed) return normal();
    return (-std::log(uniform()) - std::log(uniform()) - 2.0) / std::sqrt(2.0);
  }

 private:
  RandomStream stream_;
  std::uint32_t next_ = 0;
};

// A mean over clusters of unequal length, whose own errors are large beside those within.
bool interval_holds(std::size_t clusters, bool skewed, std::uint64_t campaign) {
  CampaignDraws draws(campaign);
  WeightedRatio mean;
  for (std::size_t c = 0; c < clusters; ++c) {
    const double count = 600.0 + std::floor(500.0 * draws.uniform());
    const double mean_m = kTruth_m + 0.02 * draws.error(skewed) + 0.005 * draws.normal();
    mean.numerator.push_back(mean_m * count);
    mean.denominator.push_back(count);
  }
  const Estimate e = solve_contrast({{mean}, {}});
  return e.low() <= kTruth_m && kTruth_m <= e.high();
}

// CampaignDraws errors of twelve methods that are equally good. True when the method named beforehand is not
// told apart from the best.
bool set_holds_the_best(std::size_t clusters, std::uint64_t campaign) {
  constexpr std::size_t kMethods = 12;
  CampaignDraws draws(campaign);
  std::vector<WeightedRatio> error_m(kMethods);
  for (std::size_t c = 0; c < clusters; ++c) {
    const double who = 0.02 * draws.normal();
    for (WeightedRatio& method : error_m) {
      method.numerator.push_back(0.05 + who + 0.008 * draws.normal());
      method.denominator.push_back(1.0);
    }
  }
  const auto mean_m = [&](std::size_t m) { return solve_contrast({{error_m[m]}, {}}).value; };
  std::size_t best = 0;
  for (std::size_t m = 1; m < kMethods; ++m)
    if (mean_m(m) < mean_m(best)) best = m;
  if (best == 0) return true;
  WeightedRatio minus = error_m[best];
  minus.weight = -1.0;
  return !differs_significantly(solve_contrast({{error_m[0], minus}, {}}), kMethods - 1);
}

template <class Holds>
double percent_of(std::uint64_t campaigns, const Holds& holds) {
  std::uint64_t count = 0;
  for (std::uint64_t campaign = 0; campaign < campaigns; ++campaign) count += holds(campaign) ? 1 : 0;
  return 100.0 * static_cast<double>(count) / static_cast<double>(campaigns);
}

TEST(IntervalCoverage, OfMeansAndOfTheSetThatHoldsTheBest) {
  const std::uint64_t campaigns = trials(2000);
  const double slack_percent = 100.0 * slack(0.95, campaigns);
  std::printf("clusters  normal  skewed  set of 12 equal methods holds the best\n");
  for (const std::size_t clusters : {2u, 3u, 4u, 8u, 16u}) {
    const double normal =
        percent_of(campaigns, [&](std::uint64_t k) { return interval_holds(clusters, false, k); });
    const double skewed =
        percent_of(campaigns, [&](std::uint64_t k) { return interval_holds(clusters, true, k); });
    const double set =
        percent_of(campaigns, [&](std::uint64_t k) { return set_holds_the_best(clusters, k); });
    std::printf("%8zu  %5.1f   %5.1f   %5.1f\n", clusters, normal, skewed, set);
    EXPECT_GE(normal, 93.5 - slack_percent) << clusters;
    EXPECT_LE(normal, 96.5 + slack_percent) << clusters;
    EXPECT_GE(skewed, 91.0 - slack_percent) << clusters;
    EXPECT_GE(set, 95.0 - slack_percent) << clusters;
  }
}

TEST(Intervals, CountClustersWithDataAlone) {
  const auto [low, high] = mean_interval({11.0, 12.0, 16.0, 0.0}, {1.0, 1.0, 1.0, 0.0});
  EXPECT_NEAR(low, 13.0 - 4.302653 * std::sqrt(7.0 / 3.0), 1e-6);  // Student's t of two degrees
  EXPECT_NEAR(high, 13.0 + 4.302653 * std::sqrt(7.0 / 3.0), 1e-6);
  EXPECT_EQ(mean_interval({1.0, 2.0, 6.0}, {1.0, 1.0, 1.0}).first, 0.0);  // no size is below zero
  EXPECT_TRUE(std::isnan(mean_interval({1.0}, {1.0}).first));
  EXPECT_TRUE(std::isnan(mean_interval({1.0}, {1.0}).second));
}

// Clopper and Pearson's own interval of 9 in 10, and of 10 in 10: (alpha / 2)^(1/10).
TEST(Shares, AreExactForIndependentTrials) {
  const ShareEstimate most = estimate_share(9.0, 10.0), all = estimate_share(10.0, 10.0);
  EXPECT_NEAR(most.low, 0.55498, 1e-5);
  EXPECT_NEAR(most.high, 0.99747, 1e-5);
  EXPECT_NEAR(all.low, std::pow(0.025, 0.1), 1e-9);
  EXPECT_EQ(all.high, 1.0);
  EXPECT_NEAR(all.chance_of_more(0.5), std::pow(0.5, 10), 1e-12);
  EXPECT_EQ(all.chance_of_fewer(0.5), 1.0);
}

// 16 runs of a thousand frames, in each of which all are right: as much is known as from 16 trials.
TEST(Shares, ClustersWithoutAnySpreadCountAsOneTrialEach) {
  const std::vector<double> frames(16, 1000.0);
  const ShareEstimate all = estimate_share(frames, frames);
  EXPECT_EQ(all.value, 1.0);
  EXPECT_NEAR(all.low, std::pow(0.025, 1.0 / 16.0), 1e-9);
  EXPECT_NEAR(all.chance_of_more(0.9), std::pow(0.9, 16), 1e-12);
  EXPECT_TRUE(std::isnan(estimate_share(std::vector{1.0}, std::vector{1.0}).low));
}

// 40 clusters of 25 trials that share a cause: the shares of clusters are beta distributed.
TEST(Shares, OfClustersHoldTheTruth) {
  constexpr double kShare = 0.95, kTogether = 20.0;  // a beta distribution of a + b = kTogether
  constexpr int kSets = 1000;
  int held = 0, within = 0;
  std::mt19937_64 random(7);
  std::gamma_distribution<double> of_share(kShare * kTogether), of_rest((1.0 - kShare) * kTogether);
  for (int set = 0; set < kSets; ++set) {
    std::vector<double> successes, trials(40, 25.0);
    for (std::size_t c = 0; c < trials.size(); ++c) {
      const double a = of_share(random), b = of_rest(random);
      successes.push_back(std::binomial_distribution<int>(25, a / (a + b))(random));
    }
    const ShareEstimate share = estimate_share(successes, trials);
    held += share.low <= kShare && kShare <= share.high;
    within += share.low >= 0.0 && share.high <= 1.0 && share.low < share.high;
  }
  EXPECT_GE(held, 930);
  EXPECT_EQ(within, kSets);
}

}  // namespace
}  // namespace trilat
