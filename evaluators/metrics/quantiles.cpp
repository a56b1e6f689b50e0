// SPDX-License-Identifier: MIT
#include "evaluators/metrics/quantiles.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "datasets/base/error.h"

namespace trilat {

namespace {

// Puts the values of all `ranks`, which rise, in their places; `values` begins at rank `first`.
void place(std::span<double> values, std::size_t first, std::span<const std::size_t> ranks) {
  if (ranks.empty()) return;
  const std::size_t middle = ranks.size() / 2, at = ranks[middle] - first;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  place(values.first(at), first, ranks.first(middle));
  place(values.subspan(at + 1), ranks[middle] + 1, ranks.subspan(middle + 1));
}

}  // namespace

std::vector<double> quantiles_of(std::vector<double> values, const std::vector<double>& quantiles) {
  TRILAT_CHECK(std::ranges::is_sorted(quantiles) &&
                   (quantiles.empty() || (quantiles.front() >= 0.0 && quantiles.back() <= 1.0)),
               "quantiles rise from 0 to 1");
  TRILAT_CHECK(std::ranges::none_of(values, [](double x) { return std::isnan(x); }), "a value is a number");
  std::vector<double> result(quantiles.size(), std::numeric_limits<double>::quiet_NaN());
  if (values.empty()) return result;
  const std::size_t last = values.size() - 1;
  std::vector<std::size_t> ranks;
  for (const double q : quantiles)
    for (const std::size_t above : {0, 1})
      ranks.push_back(
          std::min(static_cast<std::size_t>(std::floor(static_cast<double>(last) * q)) + above, last));
  std::ranges::sort(ranks);
  ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
  place(values, 0, ranks);
  for (std::size_t i = 0; i < quantiles.size(); ++i) {
    const double position = static_cast<double>(last) * quantiles[i], share = position - std::floor(position);
    const auto rank = static_cast<std::size_t>(position);
    const double below = values[rank], above = values[std::min(rank + 1, last)];
    result[i] = share == 0.0 || below == above ? below : below + share * (above - below);
  }
  return result;
}

}  // namespace trilat
