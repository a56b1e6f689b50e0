// SPDX-License-Identifier: MIT
#include "pipeline/claims/verdict.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "evaluators/metrics/student_tail.h"

namespace trilat {
namespace {

constexpr double kPower80 = 0.8416212335729143;  // quantile of the normal distribution at 80 %
constexpr std::size_t kMostClusters = 10'000;

// Twice the probability that Student's t is at least this.
double twice_above(double t, std::size_t degrees) {
  const double both = student_two_sided(t, degrees);
  return t > 0.0 ? both : 2.0 - both;
}

// How far the estimate lies from the margin on the side where the claim holds; below 0 on the other.
double depth_of(double value, const ClaimBound& bound) {
  switch (bound.side) {
    case ClaimBound::Side::more_than:
      return value - bound.margin;
    case ClaimBound::Side::less_than:
      return bound.margin - value;
    case ClaimBound::Side::within:
      return bound.margin - std::abs(value);
  }
  return kNaN;
}

}  // namespace

ClaimChance chance_of(const ContrastEstimate& e, const ClaimBound& bound) {
  const double depth = depth_of(e.value, bound);
  if (e.clusters < 2 || !std::isfinite(e.standard_error) || !std::isfinite(depth) || depth == 0.0) return {};
  const double t = depth / e.standard_error;
  return {std::min(1.0, twice_above(t, e.clusters - 1)), std::min(1.0, twice_above(-t, e.clusters - 1))};
}

ClaimChance chance_of_all(const std::vector<ClaimChance>& parts) {
  ClaimChance all{0.0, 1.0};
  for (const ClaimChance& part : parts) {
    all.holds = std::max(all.holds, part.holds);
    all.fails = std::min(all.fails, part.fails * static_cast<double>(parts.size()));
  }
  return parts.empty() ? ClaimChance{} : all;
}

std::optional<std::size_t> clusters_needed(const ContrastEstimate& e, const ClaimBound& bound,
                                           double chance) {
  const double depth = std::abs(depth_of(e.value, bound));
  if (e.clusters < 2 || !std::isfinite(depth) || !(e.standard_error > 0.0)) return std::nullopt;
  const double spread = e.standard_error * std::sqrt(static_cast<double>(e.clusters));
  const auto enough = [&](std::size_t n) {
    return twice_above(depth * std::sqrt(static_cast<double>(n)) / spread - kPower80, n - 1) <= chance;
  };
  if (!enough(kMostClusters)) return std::nullopt;
  std::size_t no = 1, yes = kMostClusters;
  while (yes - no > 1) {
    const std::size_t middle = no + (yes - no) / 2;
    (enough(middle) ? yes : no) = middle;
  }
  return yes;
}

std::string size_beside(const ContrastEstimate& e, double paper) {
  const double ratio = e.value / paper;
  const auto [low, high] = std::minmax({e.low() / paper, e.high() / paper});
  if (low > 1.25) return fmt::format("{:.1f} times the size", ratio);
  if (!(ratio > 0.0 && high < 0.8)) return {};
  constexpr std::array<std::pair<double, const char*>, 7> kWords{{{0.1, "a tenth"},
                                                                  {0.2, "a fifth"},
                                                                  {0.25, "a quarter"},
                                                                  {1.0 / 3.0, "a third"},
                                                                  {0.5, "half"},
                                                                  {2.0 / 3.0, "two thirds"},
                                                                  {0.75, "three quarters"}}};
  if (ratio < 0.07) return fmt::format("{:.1g} % of the size", 100.0 * ratio);
  const auto nearest = std::min_element(kWords.begin(), kWords.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.first - ratio) < std::abs(b.first - ratio);
  });
  return std::string(nearest->second) + " of the size";
}

}  // namespace trilat
