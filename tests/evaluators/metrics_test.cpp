// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"
#include "evaluators/metrics/error_statistics.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

double sorted_quantile(std::vector<double> values, double q) {
  std::ranges::sort(values);
  const double position = static_cast<double>(values.size() - 1) * q;
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (position - static_cast<double>(below)) * (values[above] - values[below]);
}

const std::vector<double> kProbes{0.0, 0.01, 0.25, 0.5, 0.9, 0.95, 0.999, 1.0};

void expect_as_sorted(const std::vector<double>& values) {
  const std::vector<double> found = quantiles_of(values, kProbes);
  for (std::size_t i = 0; i < kProbes.size(); ++i)
    EXPECT_EQ(found[i], sorted_quantile(values, kProbes[i])) << "q " << kProbes[i];
}

TEST(Quantiles, ByPencil) {
  EXPECT_THAT(quantiles_of(std::vector<double>{4, 1, 3, 2}, {0.0, 0.5, 1.0}),
              testing::ElementsAre(1.0, 2.5, 4.0));
  // position (5 - 1) * 0.9 = 3.6 between 4 and 5
  EXPECT_NEAR(quantiles_of(std::vector<double>{5, 4, 3, 2, 1}, {0.9})[0], 4.6, 1e-15);
  EXPECT_NEAR(quantiles_of(std::vector<double>{5, 1, 3}, {0.05})[0], 1.2, 1e-15);
  EXPECT_EQ(quantiles_of(std::vector<double>{7}, {0.95})[0], 7.0);
  EXPECT_EQ(quantiles_of(std::vector<double>{0.0, -0.0}, {0.5})[0], 0.0);
}

TEST(Quantiles, OfNothingAreNotANumber) {
  EXPECT_TRUE(std::isnan(quantiles_of({}, {0.5})[0]));
  EXPECT_TRUE(quantiles_of(std::vector<double>{1.0, 2.0}, {}).empty());
}

TEST(Quantiles, AreThoseOfTheSortedValues) {
  const RandomStream random{31, Purpose::test, 0};
  for (const int n : {1, 2, 3, 10, 101, 5000}) {
    std::vector<double> uniform, equal, huge_range, few_values, dense;
    for (int i = 0; i < n; ++i) {
      const auto draw = static_cast<std::uint32_t>(i);
      uniform.push_back(random.uniform(draw));
      equal.push_back(0.1);
      huge_range.push_back(std::pow(10.0, random.uniform(draw, -300.0, 300.0)));
      few_values.push_back(std::floor(random.uniform(draw, 0.0, 4.0)));
      dense.push_back(1.0 + std::floor(random.uniform(draw, 0.0, 50.0)) * 0x1p-52);
    }
    huge_range[0] = std::numeric_limits<double>::denorm_min();
    for (const auto& values : {uniform, equal, huge_range, few_values, dense}) expect_as_sorted(values);
  }
}

TEST(Quantiles, InfinityIsTheLargestValue) {
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_THAT(quantiles_of(std::vector<double>{inf, 1.0, 2.0}, {0.5, 1.0}), testing::ElementsAre(2.0, inf));
}

TEST(Quantiles, RefuseWhatIsNoNumberAndQuantilesThatDoNotRise) {
  EXPECT_THROW((void)quantiles_of({1.0, kNaN}, {0.5}), InternalError);
  EXPECT_THROW((void)quantiles_of({1.0}, {1.5}), InternalError);
  EXPECT_THROW((void)quantiles_of({1.0}, {0.5, 0.25}), InternalError);
}

struct Item {
  SolveStatus status;
  Vector3d error_m;
};

ErrorSums sums_of(std::span<const Item> items) {
  ErrorSums sums;
  for (const Item& item : items) sums.add(item.status, item.error_m);
  return sums;
}

TEST(ErrorSums, ByPencil) {
  const Vector3d nan = Vector3d::Constant(kNaN);
  const std::vector<Item> items{{SolveStatus::converged, {3, -4, 0}},
                                {SolveStatus::clamped, {0, 0, -1}},
                                {SolveStatus::rank_deficient, nan},
                                {SolveStatus::closed_form, {-2, 1, 2}},
                                {SolveStatus::mirror_ambiguous, {9, 9, 9}}};
  const ErrorSums s = sums_of(items);
  EXPECT_EQ(s.asked(), 5);
  EXPECT_EQ(s.answered(), 3);
  EXPECT_EQ(s.count_of(SolveStatus::rank_deficient), 1);
  EXPECT_EQ(s.count_of(SolveStatus::mirror_ambiguous), 1);
  EXPECT_NEAR(s.mae_m(), (5.0 + 1.0 + 3.0) / 3.0, 1e-15);
  EXPECT_LT((s.axis_mae_m() - Vector3d(5, 5, 3) / 3.0).norm(), 1e-15);
  EXPECT_NEAR(s.rmse_m(), std::sqrt((25.0 + 1.0 + 9.0) / 3.0), 1e-15);
  EXPECT_EQ(s.max_m(), 5.0);
}

TEST(ErrorSums, WithoutAnswersAreNotANumberAndNotZero) {
  const std::vector<Item> failed{{SolveStatus::diverged, Vector3d::Constant(kNaN)}};
  for (const ErrorSums& s : {ErrorSums(), sums_of(failed)}) {
    EXPECT_EQ(s.answered(), 0);
    for (const double value : {s.mae_m(), s.axis_mae_m().x(), s.axis_mae_m().z(), s.rmse_m(), s.max_m()})
      EXPECT_TRUE(std::isnan(value));
  }
}

TEST(ErrorSums, AUsableEstimateWithoutANumberIsOurMistake) {
  ErrorSums sums;
  EXPECT_THROW(sums.add(SolveStatus::converged, Vector3d::Constant(kNaN)), InternalError);
}

TEST(ErrorSums, MergedAreThoseOfTheWhole) {
  const RandomStream random{33, Purpose::test, 0};
  std::vector<Item> items;
  for (std::uint32_t i = 0; i < 100; ++i)
    items.push_back({i % 7 == 0 ? SolveStatus::diverged : SolveStatus::converged,
                     {random.normal(3 * i), random.normal(3 * i + 1), random.normal(3 * i + 2)}});
  ErrorSums merged = sums_of(std::span(items).first(30));
  merged.merge(sums_of(std::span(items).subspan(30)));
  EXPECT_EQ(merged.asked(), 100);
  EXPECT_EQ(merged.count_of(SolveStatus::diverged), 15);
  const ErrorSums whole = sums_of(items);
  EXPECT_NEAR(merged.mae_m(), whole.mae_m(), 1e-15);
  EXPECT_NEAR(merged.rmse_m(), whole.rmse_m(), 1e-15);
  EXPECT_LT((merged.axis_mae_m() - whole.axis_mae_m()).norm(), 1e-15);
  EXPECT_EQ(merged.max_m(), whole.max_m());
}

TEST(CompensatedSum, KeepsWhatAPlainSumLoses) {
  CompensatedSum sum;
  for (const double value : {1.0, 1e100, 1.0, -1e100}) sum.add(value);
  EXPECT_EQ(sum.value(), 2.0);
  CompensatedSum tenths;
  for (int i = 0; i < 10'000'000; ++i) tenths.add(0.1);
  EXPECT_NEAR(tenths.value(), 1e6, 1e-9);
}

}  // namespace
}  // namespace trilat
