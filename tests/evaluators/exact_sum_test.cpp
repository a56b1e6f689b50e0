// SPDX-License-Identifier: MIT
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "datasets/base/philox.h"
#include "evaluators/metrics/error_statistics.h"

namespace trilat {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double sum_of(const std::vector<double>& terms) {
  ExactSum sum;
  for (const double term : terms) sum.add(term);
  return sum.value();
}

double uniform(std::uint64_t seed, std::uint32_t index) {
  return RandomStream{seed, Purpose::test, 7}.uniform(index);
}

// Of any sign, from 1e-200 to 1e200.
std::vector<double> wild_terms(std::uint64_t seed, std::uint32_t count) {
  std::vector<double> terms;
  for (std::uint32_t i = 0; i < count; ++i)
    terms.push_back((2.0 * uniform(seed, 2 * i) - 1.0) *
                    std::pow(10.0, 400.0 * uniform(seed, 2 * i + 1) - 200.0));
  return terms;
}

std::vector<double> shuffled(std::vector<double> terms, std::uint64_t seed) {
  for (std::uint32_t i = static_cast<std::uint32_t>(terms.size()); i > 1; --i)
    std::swap(terms[i - 1], terms[static_cast<std::size_t>(uniform(seed, i) * i)]);
  return terms;
}

TEST(ExactSum, LosesNothingToCancellation) {
  EXPECT_EQ(sum_of({}), 0.0);
  EXPECT_EQ(sum_of({1e100, 1.0, -1e100}), 1.0);
  EXPECT_EQ(sum_of({1.0, 1e100, 1.0, -1e100}), 2.0);
  EXPECT_EQ(sum_of({1e16, 1.0, 1e-16, -1e16, -1.0, -1e-16}), 0.0);
  EXPECT_EQ(sum_of(std::vector<double>(10, 0.1)), 1.0);  // one after the other gives 0.9999999999999999
  EXPECT_EQ(sum_of({5e-324, 1.0, -1.0}), 5e-324);
}

TEST(ExactSum, RoundsOnceAndToEven) {
  const double half = 0x1p-53;  // of the last place of 1
  EXPECT_EQ(sum_of({1.0, half}), 1.0);
  EXPECT_EQ(sum_of({1.0, half, 0x1p-120}), 1.0 + 2 * half);
  EXPECT_EQ(sum_of({1.0, half, -0x1p-120}), 1.0);
  EXPECT_EQ(sum_of({1.0 + 2 * half, half}), 1.0 + 4 * half);
  EXPECT_EQ(sum_of({1.0 + 2 * half, half, -0x1p-120}), 1.0 + 2 * half);
  EXPECT_EQ(sum_of({-1.0, -half, -0x1p-120}), -1.0 - 2 * half);
}

TEST(ExactSum, EveryOrderAndGroupingGivesTheSameBits) {
  int naive_differs = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    std::vector<double> terms = wild_terms(seed, 200);
    const std::size_t half = terms.size();
    for (std::size_t i = 0; i < half; ++i)  // nearly all of it cancels
      terms.push_back(-terms[i] * (1.0 - 1e-12 * uniform(seed, 9000 + static_cast<std::uint32_t>(i))));
    const double expected = sum_of(terms);
    double naive = 0.0;
    for (const double term : terms) naive += term;
    naive_differs += naive != expected;
    for (std::uint64_t order = 1; order <= 10; ++order) {
      const std::vector<double> other = shuffled(terms, 1000 * seed + order);
      std::vector<ExactSum> groups(1 + order);
      for (std::size_t i = 0; i < other.size(); ++i) groups[i * i % groups.size()].add(other[i]);
      ExactSum all, again;
      for (const ExactSum& group : groups) all.add(group);
      for (const double part : all.parts()) again.add(part);
      ASSERT_EQ(std::bit_cast<std::uint64_t>(all.value()), std::bit_cast<std::uint64_t>(expected));
      ASSERT_EQ(std::bit_cast<std::uint64_t>(again.value()), std::bit_cast<std::uint64_t>(expected));
    }
  }
  EXPECT_GT(naive_differs, 25);
}

TEST(ExactSum, OfManyIntegersIsTheirSum) {
  ExactSum sum;
  std::uint64_t expected = 0;
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    const std::uint64_t term = i * 0x9E3779B97F4A7C15ull >> 17;
    sum.add(static_cast<double>(term));
    expected += term;
  }
  EXPECT_EQ(sum.value(), static_cast<double>(expected));
  EXPECT_LE(sum.parts().size(), 3u);
}

TEST(ExactSum, WhatIsNotFiniteStaysSo) {
  EXPECT_EQ(sum_of({1.0, kInfinity, -5.0}), kInfinity);
  EXPECT_TRUE(std::isnan(sum_of({kInfinity, 1.0, -kInfinity})));
  EXPECT_TRUE(std::isnan(sum_of({std::nan(""), 1.0})));
  EXPECT_EQ(sum_of({1.7e308, 1.7e308}), kInfinity);
}

}  // namespace
}  // namespace trilat
