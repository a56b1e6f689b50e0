// SPDX-License-Identifier: MIT
#include "evaluators/metrics/change_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/base/check.h"

namespace trilat {
namespace {

constexpr double kNormalMad = 1.4826022185;  // standard deviations a median absolute deviation

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double sigma_of_differences(std::span<const double> values) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < values.size(); ++i) steps.push_back(std::abs(values[i] - values[i - 1]));
  return steps.empty() ? 0.0 : kNormalMad * median(steps) / std::sqrt(2.0);
}

// Squared residuals of any stretch around its mean, from running sums of values less their first.
class StretchCost {
 public:
  explicit StretchCost(std::span<const double> values)
      : origin_(values.front()), sum_(values.size() + 1), squares_(values.size() + 1) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double v = values[i] - origin_;
      sum_[i + 1] = sum_[i] + v;
      squares_[i + 1] = squares_[i] + v * v;
    }
  }
  double level(std::size_t first, std::size_t end) const {
    return origin_ + (sum_[end] - sum_[first]) / static_cast<double>(end - first);
  }
  double of(std::size_t first, std::size_t end) const {
    const double sum = sum_[end] - sum_[first];
    return std::max(0.0, squares_[end] - squares_[first] - sum * sum / static_cast<double>(end - first));
  }

 private:
  double origin_;
  std::vector<double> sum_, squares_;
};

std::vector<Stretch> cheapest(const StretchCost& cost, std::size_t n, std::size_t shortest, double penalty) {
  std::vector<double> best(n + 1, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> from(n + 1, 0);
  best[0] = -penalty;
  for (std::size_t end = shortest; end <= n; ++end)
    for (std::size_t first = 0; first + shortest <= end; ++first) {
      const double here = best[first] + cost.of(first, end) + penalty;
      if (here >= best[end]) continue;
      best[end] = here;
      from[end] = first;
    }
  std::vector<Stretch> stretches;
  for (std::size_t end = n; end > 0; end = from[end])
    stretches.push_back({from[end], end, cost.level(from[end], end)});
  std::reverse(stretches.begin(), stretches.end());
  return stretches;
}

}  // namespace

Segmentation find_change_points(std::span<const double> values, const ChangePointOptions& options) {
  Segmentation result;
  const std::size_t n = values.size();
  if (n == 0) return result;
  for (const double value : values) TRILAT_CHECK(std::isfinite(value), "a series has finite values");
  const StretchCost cost(values);
  const std::size_t shortest = std::clamp<std::size_t>(options.shortest, 1, n);
  result.sigma = std::max(options.least_sigma, sigma_of_differences(values));
  constexpr int kPasses = 2;  // with the noise of differences, then with that around the levels
  for (int pass = 0; pass < kPasses; ++pass) {
    const double penalty = options.penalty * result.sigma * result.sigma *
                           std::log(static_cast<double>(std::max<std::size_t>(n, 2)));
    result.stretches = cheapest(cost, n, shortest, penalty);
    double squares = 0.0;
    for (const Stretch& s : result.stretches) squares += cost.of(s.first, s.end);
    const std::size_t levels = result.stretches.size();
    if (n <= 2 * levels) break;  // too little left to judge noise by
    result.sigma =
        std::max({options.least_sigma, result.sigma, std::sqrt(squares / static_cast<double>(n - levels))});
  }
  return result;
}

}  // namespace trilat
