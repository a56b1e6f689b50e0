// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"
#include "evaluators/metrics/statistics.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {
namespace {

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

}  // namespace
}  // namespace trilat
