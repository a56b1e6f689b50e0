// SPDX-License-Identifier: MIT
#include "evaluators/metrics/sobol_indices.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include <gsl/gsl_qrng.h>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"

namespace trilat {
namespace {

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double variance_of(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double sum = 0.0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return sum / static_cast<double>(values.size());
}

// First and total index of each factor.
std::vector<double> indices_of(std::span<const double> values, std::size_t factors,
                               std::span<const std::size_t> rows) {
  std::vector<double> indices;
  for (std::size_t i = 0; i < factors; ++i) {
    std::vector<double> both, alone, together;
    for (const std::size_t row : rows) {
      const double* f = &values[row * (factors + 2)];
      const double a = f[0], b = f[1], exchanged = f[2 + i];
      if (!std::isfinite(a + b + exchanged)) continue;
      both.insert(both.end(), {a, b});
      alone.push_back(b * (exchanged - a));
      together.push_back(0.5 * (a - exchanged) * (a - exchanged));
    }
    // about the mean, as the products lose less to rounding and noise
    const double mean = mean_of(both), variance = variance_of(both);
    double shift = 0.0;
    for (const std::size_t row : rows) {
      const double* f = &values[row * (factors + 2)];
      if (std::isfinite(f[0] + f[1] + f[2 + i])) shift += mean * (f[2 + i] - f[0]);
    }
    indices.push_back((mean_of(alone) - shift / static_cast<double>(alone.size())) / variance);
    indices.push_back(mean_of(together) / variance);
  }
  return indices;
}

WithInterval with_interval(double value, std::vector<double> resampled) {
  const std::size_t asked = resampled.size();
  std::erase_if(resampled, [](double v) { return !std::isfinite(v); });
  if (!std::isfinite(value) || 20 * resampled.size() < 19 * asked) return {value, kNaN, kNaN};
  if (resampled.empty()) return {value, kNaN, kNaN};
  std::ranges::sort(resampled);
  const auto end_of = [&](double share) {
    return resampled[static_cast<std::size_t>(share * static_cast<double>(resampled.size() - 1) + 0.5)];
  };
  return {value, end_of(0.025), end_of(0.975)};
}

}  // namespace

std::vector<std::vector<double>> saltelli_design(std::size_t factors, std::size_t rows) {
  TRILAT_CHECK(factors >= 1 && factors <= kMostFactors, "the sequence has so many dimensions");
  const std::unique_ptr<gsl_qrng, void (*)(gsl_qrng*)> sequence(
      gsl_qrng_alloc(gsl_qrng_sobol, static_cast<unsigned>(2 * factors)), gsl_qrng_free);
  std::vector<std::vector<double>> points;
  std::vector<double> both(2 * factors);
  const auto half = static_cast<std::ptrdiff_t>(factors);
  for (std::size_t row = 0; row < rows; ++row) {
    gsl_qrng_get(sequence.get(), both.data());
    const std::vector<double> a(both.begin(), both.begin() + half), b(both.begin() + half, both.end());
    points.push_back(a);
    points.push_back(b);
    for (std::size_t i = 0; i < factors; ++i) {
      points.push_back(a);
      points.back()[i] = b[i];
    }
  }
  return points;
}

std::vector<WithInterval> bootstrap_rows(
    std::size_t rows, std::size_t resamples, std::uint64_t seed,
    const std::function<std::vector<double>(std::span<const std::size_t>)>& statistics) {
  std::vector<std::size_t> chosen(rows);
  std::iota(chosen.begin(), chosen.end(), std::size_t{0});
  const std::vector<double> values = statistics(chosen);
  std::vector<std::vector<double>> resampled(values.size());
  for (std::size_t r = 0; r < resamples; ++r) {
    const RandomStream random{seed, Purpose::bootstrap, r};
    for (std::size_t k = 0; k < rows; ++k)
      chosen[k] = std::min(rows - 1, static_cast<std::size_t>(random.uniform(static_cast<std::uint32_t>(k)) *
                                                              static_cast<double>(rows)));
    const std::vector<double> again = statistics(chosen);
    for (std::size_t v = 0; v < values.size(); ++v) resampled[v].push_back(again[v]);
  }
  std::vector<WithInterval> result;
  for (std::size_t v = 0; v < values.size(); ++v)
    result.push_back(with_interval(values[v], std::move(resampled[v])));
  return result;
}

std::vector<SobolIndices> sobol_indices(std::span<const double> values, std::size_t factors,
                                        std::size_t resamples, std::uint64_t seed) {
  TRILAT_CHECK(values.size() % (factors + 2) == 0, "the values are of whole rows");
  const std::vector<WithInterval> list =
      bootstrap_rows(values.size() / (factors + 2), resamples, seed,
                     [&](std::span<const std::size_t> rows) { return indices_of(values, factors, rows); });
  std::vector<SobolIndices> indices;
  for (std::size_t i = 0; i < factors; ++i) indices.push_back({list[2 * i], list[2 * i + 1]});
  return indices;
}

double crossing_of_line(std::span<const double> x, std::span<const double> y) {
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!std::isfinite(y[k])) continue;
    n += 1.0;
    sx += x[k];
    sy += y[k];
    sxx += x[k] * x[k];
    sxy += x[k] * y[k];
  }
  const double crossing = (sx * sxy - sxx * sy) / (n * sxy - sx * sy);
  return std::isfinite(crossing) ? std::clamp(crossing, 0.0, 1.0) : kNaN;
}

}  // namespace trilat
