// SPDX-License-Identifier: MIT
#include "evaluators/metrics/ratio_change.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

bool can_be_used(std::span<const double> ratios) {
  return ratios.size() >= 2 &&
         std::all_of(ratios.begin(), ratios.end(), [](double r) { return std::isfinite(r) && r > 0.0; });
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double median_of(std::span<const double> values) {
  std::vector<double> copy(values.begin(), values.end());
  return median(copy);
}

class Redrawn {
 public:
  Redrawn(std::span<const double> values, const RandomStream& random) : values_(values), random_(random) {}
  double median_once(std::uint32_t& draw) {
    drawn_.clear();
    for (std::size_t i = 0; i < values_.size(); ++i)
      drawn_.push_back(values_[std::min(
          values_.size() - 1,
          static_cast<std::size_t>(random_.uniform(draw++) * static_cast<double>(values_.size())))]);
    return median(drawn_);
  }

 private:
  std::span<const double> values_;
  const RandomStream& random_;
  std::vector<double> drawn_;
};

double rank_sum_chance(std::span<const double> now, std::span<const double> before) {
  struct Value {
    double value;
    bool is_now;
  };
  std::vector<Value> all;
  for (const double r : now) all.push_back({r, true});
  for (const double r : before) all.push_back({r, false});
  std::sort(all.begin(), all.end(), [](const Value& a, const Value& b) { return a.value < b.value; });
  double rank_sum = 0.0, ties = 0.0;
  for (std::size_t first = 0; first < all.size();) {
    std::size_t end = first;
    while (end < all.size() && all[end].value == all[first].value) ++end;
    const double rank = 0.5 * static_cast<double>(first + end + 1);
    for (std::size_t i = first; i < end; ++i) rank_sum += all[i].is_now ? rank : 0.0;
    const auto t = static_cast<double>(end - first);
    ties += t * t * t - t;
    first = end;
  }
  const auto a = static_cast<double>(now.size()), b = static_cast<double>(before.size()), n = a + b;
  const double u = rank_sum - a * (a + 1.0) / 2.0 - a * b / 2.0;
  const double variance = a * b / 12.0 * (n + 1.0 - ties / (n * (n - 1.0)));
  if (variance <= 0.0) return 1.0;
  const double z = std::max(0.0, std::abs(u) - 0.5) / std::sqrt(variance);  // with continuity correction
  return std::erfc(z / std::sqrt(2.0));
}

}  // namespace

RatioChange solve_ratio_change(std::span<const double> now, std::span<const double> before,
                               const RatioChangeOptions& options) {
  RatioChange result;
  if (!can_be_used(now) || !can_be_used(before)) return result;
  result.now = median_of(now);
  result.before = median_of(before);
  result.change = result.now / result.before - 1.0;
  result.chance = rank_sum_chance(now, before);
  std::vector<double> changes;
  for (std::size_t r = 0; r < options.resamples; ++r) {
    const RandomStream random{options.seed, Purpose::bootstrap, r};
    std::uint32_t draw = 0;
    const double here = Redrawn(now, random).median_once(draw);
    changes.push_back(here / Redrawn(before, random).median_once(draw) - 1.0);
  }
  if (changes.empty()) return result;
  std::sort(changes.begin(), changes.end());
  const auto at = [&](double q) {
    return changes[static_cast<std::size_t>(q * static_cast<double>(changes.size() - 1))];
  };
  result.low = at(0.025);
  result.high = at(0.975);
  return result;
}

}  // namespace trilat
