// SPDX-License-Identifier: MIT
#include "evaluators/metrics/sobol_indices.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

std::vector<double> values_of(const std::vector<std::vector<double>>& points,
                              double (*f)(std::span<const double>)) {
  std::vector<double> values;
  for (const std::vector<double>& point : points) values.push_back(f(point));
  return values;
}

// Ishigami and Homma 1990, a = 7, b = 0.1: its indices are known in closed form.
double ishigami(std::span<const double> u) {
  const auto x = [&](std::size_t i) { return std::numbers::pi * (2.0 * u[i] - 1.0); };
  return std::sin(x(0)) + 7.0 * std::pow(std::sin(x(1)), 2) + 0.1 * std::pow(x(2), 4) * std::sin(x(0));
}

TEST(SobolIndices, AreThoseOfAFunctionOfWhichTheyAreKnown) {
  const auto indices = sobol_indices(values_of(saltelli_design(3, 2048), ishigami), 3, 200, 1);
  const double first[] = {0.3139, 0.4424, 0.0}, total[] = {0.5576, 0.4424, 0.2437};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(indices[i].first.value, first[i], 0.02) << i;
    EXPECT_NEAR(indices[i].total.value, total[i], 0.02) << i;
    EXPECT_LT(indices[i].first.low, first[i]) << i;
    EXPECT_GT(indices[i].first.high, first[i]) << i;
    EXPECT_LT(indices[i].total.low, total[i]) << i;
    EXPECT_GT(indices[i].total.high, total[i]) << i;
  }
}

TEST(SobolIndices, RowsWithoutAValueAreLeftOut) {
  std::vector<double> values = values_of(saltelli_design(3, 2048), ishigami);
  for (std::size_t k = 0; k < values.size(); k += 50) values[k] = std::nan("");
  EXPECT_NEAR(sobol_indices(values, 3, 0, 1)[1].first.value, 0.4424, 0.04);
}

TEST(SobolIndices, ALargeMeanDoesNotSpoilThem) {
  std::vector<double> values = values_of(saltelli_design(3, 2048), ishigami);
  for (double& value : values) value += 1e4;
  EXPECT_NEAR(sobol_indices(values, 3, 0, 1)[1].first.value, 0.4424, 0.02);
}

TEST(SaltelliDesign, FillsTheCubeEvenlyAndExchangesOneCoordinate) {
  const auto points = saltelli_design(4, 256);
  double mean = 0.0;
  for (std::size_t row = 0; row < 256; ++row) {
    const auto* p = &points[row * 6];
    mean += p[0][2] / 256.0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(p[2 + i][k], k == i ? p[1][k] : p[0][k]);
  }
  EXPECT_NEAR(mean, 0.5, 0.01);
}

TEST(Crossing, IsWhereTheLineChangesItsSignWithinTheRange) {
  std::vector<double> x, rising, above, level;
  for (int k = 0; k <= 20; ++k) {
    x.push_back(k / 20.0);
    rising.push_back(2.0 * x.back() - 0.6);
    above.push_back(x.back() + 0.1);
    level.push_back(0.0);
  }
  EXPECT_NEAR(crossing_of_line(x, rising), 0.3, 1e-9);
  EXPECT_EQ(crossing_of_line(x, above), 0.0);
  EXPECT_TRUE(std::isnan(crossing_of_line(x, level)));
  rising[3] = std::nan("");
  EXPECT_NEAR(crossing_of_line(x, rising), 0.3, 1e-9);
}

TEST(BootstrapRows, CoversTheMean) {
  int covered = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    std::vector<double> values;
    for (std::uint32_t k = 0; k < 100; ++k) values.push_back(RandomStream{seed, Purpose::test, 0}.normal(k));
    const WithInterval mean = bootstrap_rows(100, 400, seed, [&](std::span<const std::size_t> rows) {
      double sum = 0.0;
      for (const std::size_t row : rows) sum += values[row];
      return std::vector<double>{sum / static_cast<double>(rows.size())};
    })[0];
    covered += mean.low < 0.0 && mean.high > 0.0;
  }
  EXPECT_GE(covered, 180);
}

}  // namespace
}  // namespace trilat
