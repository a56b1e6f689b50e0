// SPDX-License-Identifier: MIT
#include "evaluators/metrics/block_bootstrap.h"

#include <cmath>
#include <numeric>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"

namespace trilat {
namespace {

std::vector<std::size_t> blocks_of(const std::vector<std::size_t>& by_cluster) {
  std::vector<std::size_t> result;
  for (std::size_t c = 0; c < by_cluster.size(); ++c) result.insert(result.end(), by_cluster[c], c);
  return result;
}

// Sums of one column of values and one of ones.
Eigen::MatrixXd block_sums_of(const std::vector<double>& values) {
  Eigen::MatrixXd sums = Eigen::MatrixXd::Ones(static_cast<Eigen::Index>(values.size()), 2);
  for (std::size_t b = 0; b < values.size(); ++b) sums(static_cast<Eigen::Index>(b), 0) = values[b];
  return sums;
}

IntervalEstimate interval_of(const std::vector<double>& values, const std::vector<std::size_t>& blocks,
                             std::size_t resamples = 2000) {
  const std::vector<RatioColumns> ratios{{0, 1}};
  const std::vector<BootstrapQuantity> quantities{{}};
  return solve_intervals(block_sums_of(values), draw_resamples(blocks_of(blocks), {resamples, 1}), ratios,
                         quantities)[0];
}

TEST(BlockResamples, DrawAsManyClustersAndBlocksAsThereAre) {
  const BlockResamples r = draw_resamples(blocks_of({3, 1, 5}), {500, 7});
  ASSERT_EQ(r.drawn.size(), 1500u);
  std::vector<int> clusters(3);
  for (std::size_t p = 0; p < r.drawn.size(); ++p) {
    ++clusters[r.drawn[p]];
    const std::size_t blocks = r.first_block[r.drawn[p] + 1] - r.first_block[r.drawn[p]];
    EXPECT_EQ(r.first_weight[p + 1] - r.first_weight[p], blocks);
    EXPECT_EQ(std::accumulate(&r.block_weight[r.first_weight[p]], &r.block_weight[r.first_weight[p]] + blocks,
                              std::size_t{0}),
              blocks);
  }
  for (const int n : clusters) EXPECT_NEAR(n, 500, 80);  // four sigma
  EXPECT_NE(draw_resamples(blocks_of({3, 1, 5}), {500, 8}).drawn, r.drawn);
  EXPECT_THROW(draw_resamples({0, 1, 0}, {}), InternalError);
}

TEST(BlockBootstrap, ValueAndStandardErrorByPencil) {
  // cluster means 1, 2, 6; their standard deviation is sqrt(7), so that of the mean is sqrt(7 / 3)
  const IntervalEstimate e = interval_of({0.5, 1.5, 2.0, 2.0, 7.0, 5.0}, {2, 2, 2});
  EXPECT_EQ(e.status, IntervalStatus::found);
  EXPECT_EQ(e.clusters, 3u);
  EXPECT_DOUBLE_EQ(e.value, 3.0);
  EXPECT_NEAR(e.standard_error, std::sqrt(7.0 / 3.0), 1e-12);
  // fewer than four clusters: Student's t of two degrees of freedom
  EXPECT_NEAR(e.high - e.value, 4.3026527297 * e.standard_error, 1e-9);
  EXPECT_NEAR(e.value - e.low, e.high - e.value, 1e-12);
}

TEST(BlockBootstrap, AMeanOfRatiosAndAQuotientByPencil) {
  // by cluster and column: 2/1, 6/3 and 3/1, 5/1
  const Eigen::MatrixXd sums = (Eigen::MatrixXd(2, 4) << 2, 1, 3, 1, 6, 3, 5, 1).finished();
  const std::vector<RatioColumns> ratios{{0, 1}, {2, 3}};
  const std::vector<BootstrapQuantity> quantities{{{0, 2}}, {{1, 1}, RatioRange{0, 1}}};
  const auto found = solve_intervals(sums, draw_resamples({0, 1}, {}), ratios, quantities);
  EXPECT_DOUBLE_EQ(found[0].value, (8.0 / 4.0 + 8.0 / 2.0) / 2.0);
  EXPECT_DOUBLE_EQ(found[1].value, 4.0 / 2.0);
  // the first ratio is 2 in both clusters; the second, 3 and 5, has standard error 1
  EXPECT_NEAR(found[0].standard_error, 0.5, 1e-12);
  EXPECT_NEAR(found[1].standard_error, 0.5, 1e-12);
}

TEST(BlockBootstrap, NoIntervalIsInventedWhereThereIsNone) {
  const IntervalEstimate one = interval_of({1.0, 2.0, 3.0}, {3});
  EXPECT_EQ(one.status, IntervalStatus::too_few_clusters);
  EXPECT_EQ(one.value, 2.0);
  EXPECT_TRUE(std::isnan(one.low) && std::isnan(one.high) && std::isnan(one.standard_error));
  const IntervalEstimate none = interval_of({1.0, 2.0, 3.0}, {1, 1, 1}, 0);
  EXPECT_EQ(none.status, IntervalStatus::no_resamples);
  EXPECT_TRUE(std::isnan(none.low));
  EXPECT_GT(none.standard_error, 0.0);
  EXPECT_EQ(interval_of({1.0, kNaN, 3.0}, {1, 1, 1}).status, IntervalStatus::not_finite);
  EXPECT_TRUE(std::isnan(interval_of({1.0, kNaN, 3.0}, {1, 1, 1}).value));
  const std::vector<RatioColumns> ratios{{0, 1}};
  const std::vector<BootstrapQuantity> quantities{{}};
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(6, 2);
  const BlockResamples resamples = draw_resamples(blocks_of({2, 2, 2}), {});
  EXPECT_EQ(solve_intervals(sums, resamples, ratios, quantities)[0].status, IntervalStatus::no_data);
  sums.row(3) << 5.0, 2.0;  // only one cluster has any
  const IntervalEstimate lone = solve_intervals(sums, resamples, ratios, quantities)[0];
  EXPECT_EQ(lone.status, IntervalStatus::too_few_clusters);
  EXPECT_EQ(lone.clusters, 1u);
  EXPECT_EQ(lone.value, 2.5);
  EXPECT_TRUE(
      solve_intervals(Eigen::MatrixXd(0, 2), draw_resamples({}, {}), ratios, quantities)[0].clusters == 0);
}

TEST(BlockBootstrap, ValuesThatAreAllEqualHaveAnIntervalOfNoLength) {
  const IntervalEstimate e = interval_of(std::vector<double>(10, 0.0), {2, 2, 2, 2, 2});
  EXPECT_EQ(e.status, IntervalStatus::found);
  EXPECT_EQ(e.low, 0.0);
  EXPECT_EQ(e.high, 0.0);
}

// Clusters without data say nothing about the spread, whatever their number.
TEST(BlockBootstrap, ClustersWithoutDataChangeNeitherValueNorStandardError) {
  const std::vector<RatioColumns> ratios{{0, 1}};
  const std::vector<BootstrapQuantity> quantities{{}};
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(10, 2);
  for (Eigen::Index b = 0; b < 5; ++b) sums.row(b) << static_cast<double>(b * b), 1.0;
  const IntervalEstimate full = interval_of({0, 1, 4, 9, 16}, {1, 1, 1, 1, 1});
  const IntervalEstimate half = solve_intervals(
      sums, draw_resamples(blocks_of(std::vector<std::size_t>(10, 1)), {}), ratios, quantities)[0];
  EXPECT_EQ(half.clusters, 5u);
  EXPECT_EQ(half.value, full.value);
  EXPECT_NEAR(half.standard_error, full.standard_error, 1e-12);
  EXPECT_EQ(half.status, IntervalStatus::found);
  EXPECT_GT(half.high - half.low, 0.8 * (full.high - full.low));
}

// Many campaigns with a known truth, side by side as columns.
struct Trials {
  std::size_t clusters = 16, blocks = 10;
  bool skewed = false;
  double mean = 0.05;
  double cluster_sigma = 0.012, block_sigma = 0.010, sample_sigma = 0.020;
  static constexpr std::size_t kCampaigns = 1000, kSamples = 4;

  double error(const RandomStream& random, std::uint32_t& draw) const {
    // an exponential less its mean has standard deviation 1 and skewness 2
    return skewed ? -std::log(random.uniform(draw++)) - 1.0 : random.normal(draw++);
  }
  // The sum of every block of one campaign.
  Eigen::VectorXd campaign(std::size_t number) const {
    const RandomStream random{31, Purpose::test, number};
    std::uint32_t draw = 0;
    double of_cluster = 0.0;
    Eigen::VectorXd sums(static_cast<Eigen::Index>(clusters * blocks));
    for (std::size_t b = 0; b < clusters * blocks; ++b) {
      if (b % blocks == 0) of_cluster = mean + cluster_sigma * error(random, draw);
      const double of_block = of_cluster + block_sigma * error(random, draw);
      double sum = 0.0;
      for (std::size_t i = 0; i < kSamples; ++i) sum += of_block + sample_sigma * error(random, draw);
      sums[static_cast<Eigen::Index>(b)] = sum;
    }
    return sums;
  }
  // Every hundred with draws of their own, so that the luck of one set of draws does not decide.
  std::vector<IntervalEstimate> intervals() const {
    constexpr std::size_t kEach = 100;
    const std::vector<std::size_t> shape(clusters, blocks);
    std::vector<IntervalEstimate> all;
    for (std::size_t first = 0; first < kCampaigns; first += kEach) {
      Eigen::MatrixXd sums(static_cast<Eigen::Index>(clusters * blocks), kEach + 1);
      std::vector<RatioColumns> ratios;
      std::vector<BootstrapQuantity> quantities;
      for (std::size_t c = 0; c < kEach; ++c) {
        sums.col(static_cast<Eigen::Index>(c)) = campaign(first + c);
        ratios.push_back({c, kEach});
        quantities.push_back({{c, 1}});
      }
      sums.col(kEach).setConstant(static_cast<double>(kSamples));
      const auto found =
          solve_intervals(sums, draw_resamples(blocks_of(shape), {2000, first + 1}), ratios, quantities);
      all.insert(all.end(), found.begin(), found.end());
    }
    return all;
  }
  // Per cent of the campaigns whose interval holds `value`.
  double percent_that_hold(double value) const {
    std::size_t held = 0;
    for (const IntervalEstimate& e : intervals()) held += e.low <= value && value <= e.high;
    return 100.0 * static_cast<double>(held) / kCampaigns;
  }
};

// 1000 campaigns: the standard error of a share of 95 % is 0.7 %.
TEST(BlockBootstrapCoverage, SixteenParticipants) {
  const Trials trials;
  const double covered = trials.percent_that_hold(trials.mean);
  RecordProperty("covered_percent", std::to_string(covered));
  EXPECT_GE(covered, 93.0);
  EXPECT_LE(covered, 97.0);
}

TEST(BlockBootstrapCoverage, SixteenParticipantsWhoDoNotDiffer) {
  Trials trials;
  trials.cluster_sigma = 0.0;
  const double covered = trials.percent_that_hold(trials.mean);
  RecordProperty("covered_percent", std::to_string(covered));
  EXPECT_GE(covered, 93.0);
  EXPECT_LE(covered, 97.0);
}

TEST(BlockBootstrapCoverage, FewParticipantsAndSkewedErrors) {
  for (const std::size_t clusters : {4u, 8u, 16u})
    for (const bool skewed : {false, true}) {
      Trials trials;
      trials.clusters = clusters;
      trials.skewed = skewed;
      const double covered = trials.percent_that_hold(trials.mean);
      const std::string what = std::to_string(clusters) + (skewed ? "_skewed" : "_normal");
      RecordProperty(what, std::to_string(covered));
      EXPECT_GE(covered, skewed ? 88.0 : 92.0) << what;
      EXPECT_LE(covered, 98.0) << what;
    }
}

// The difference of two methods on the same data, at 5 cm. In the paper's simulated campaign (16 who walk for
// 35 s) the average differences of tracked mean, median, Kalman and RTS from the mean have intervals of +-0.6
// to 0.8 %: so much do participants, blocks and samples differ here. A participant's mean spreads over the
// few blocks and samples of a trial as over 35 blocks of 30 samples that deviate by 2 and 5 mm.
Trials paired(double mean) {
  Trials trials;
  const double blocks = static_cast<double>(trials.blocks);
  trials.mean = mean;
  trials.cluster_sigma = 0.0006;
  trials.block_sigma = 0.002 * std::sqrt(blocks / 35.0);
  trials.sample_sigma = 0.005 * std::sqrt(blocks * Trials::kSamples / (35.0 * 30.0));
  return trials;
}

TEST(BlockBootstrapCoverage, ATwoPercentDifferenceIsFound) {
  const double missed = paired(0.02 * 0.05).percent_that_hold(0.0);
  RecordProperty("found_percent", std::to_string(100.0 - missed));
  EXPECT_LE(missed, 10.0);
}

// 5 % and two standard errors of a share of 1000.
TEST(BlockBootstrapCoverage, NoDifferenceIsHardlyEverFlagged) {
  const double held = paired(0.0).percent_that_hold(0.0);
  RecordProperty("flagged_percent", std::to_string(100.0 - held));
  EXPECT_LE(100.0 - held, 5.0 + 1.38);
}

}  // namespace
}  // namespace trilat
