// SPDX-License-Identifier: MIT
#include "evaluators/metrics/ratio_change.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

bool can_be_used(std::span<const double> ratios) {
  return std::all_of(ratios.begin(), ratios.end(), [](double r) { return std::isfinite(r) && r > 0.0; });
}

using Blocks = std::vector<std::span<const double>>;

Blocks blocks_of(std::span<const double> ratios, std::size_t block) {
  const std::size_t size = std::max<std::size_t>(1, block), count = ratios.size() / size;
  Blocks blocks;
  for (std::size_t b = 0; b < count; ++b)
    blocks.push_back(b + 1 == count ? ratios.subspan(b * size) : ratios.subspan(b * size, size));
  return blocks;
}

double redrawn_quantile(const Blocks& blocks, double quantile, const RandomStream& random,
                        std::uint32_t& draw) {
  std::vector<double> values;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const auto picked = static_cast<std::size_t>(random.uniform(draw++) * static_cast<double>(blocks.size()));
    const auto& block = blocks[std::min(picked, blocks.size() - 1)];
    values.insert(values.end(), block.begin(), block.end());
  }
  return quantile_of(std::move(values), quantile);
}

// That a logarithm of such a spread is so far from 0.
double normal_chance(double log_change, const std::vector<double>& logs) {
  double sum = 0.0, squares = 0.0;
  for (const double x : logs) sum += x;
  const double mean = sum / static_cast<double>(logs.size());
  for (const double x : logs) squares += (x - mean) * (x - mean);
  const double sigma = std::sqrt(squares / static_cast<double>(logs.size() - 1));
  if (log_change == 0.0) return 1.0;
  return sigma > 0.0 ? std::erfc(std::abs(log_change) / sigma / std::sqrt(2.0)) : 0.0;
}

}  // namespace

double quantile_of(std::vector<double> values, double quantile) {
  if (values.empty()) return kNaN;
  const double position = quantile * static_cast<double>(values.size() - 1);
  const auto below = values.begin() + static_cast<std::ptrdiff_t>(position);
  std::nth_element(values.begin(), below, values.end());
  const double share = position - std::floor(position);
  return share == 0.0 ? *below : *below + share * (*std::min_element(below + 1, values.end()) - *below);
}

RatioChange solve_ratio_change(std::span<const double> now, std::span<const double> before,
                               const RatioChangeOptions& options) {
  RatioChange result;
  const Blocks here = blocks_of(now, options.block), there = blocks_of(before, options.block);
  if (here.size() < 2 || there.size() < 2 || !can_be_used(now) || !can_be_used(before)) return result;
  result.now = quantile_of({now.begin(), now.end()}, options.quantile);
  result.before = quantile_of({before.begin(), before.end()}, options.quantile);
  result.change = result.now / result.before - 1.0;
  if (options.resamples < 2) return result;
  std::vector<double> changes, logs;
  for (std::size_t r = 0; r < options.resamples; ++r) {
    const RandomStream random{options.seed, Purpose::bootstrap, r};
    std::uint32_t draw = 0;
    const double drawn = redrawn_quantile(here, options.quantile, random, draw);
    changes.push_back(drawn / redrawn_quantile(there, options.quantile, random, draw) - 1.0);
    logs.push_back(std::log1p(changes.back()));
  }
  result.chance = normal_chance(std::log1p(result.change), logs);
  result.low = quantile_of(changes, 0.025);
  result.high = quantile_of(std::move(changes), 0.975);
  return result;
}

}  // namespace trilat
