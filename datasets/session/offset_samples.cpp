// SPDX-License-Identifier: MIT
#include "datasets/session/offset_samples.h"

#include <algorithm>
#include <cmath>

#include "datasets/session/exchange_segments.h"

namespace trilat {

std::int64_t twice_offset_ns(const ClockExchange& e) { return (e.t2_ns - e.t1_ns) + (e.t3_ns - e.t4_ns); }

std::vector<OffsetSample> samples_of(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns) {
  std::vector<OffsetSample> samples;
  for (const ClockExchange& e : exchanges)
    samples.push_back(
        {e.t1_ns + (e.t4_ns - e.t1_ns) / 2, static_cast<double>(twice_offset_ns(e) - 2 * base_ns) / 2.0});
  return samples;
}

std::vector<ClockExchange> least_delayed(std::vector<ClockExchange> exchanges) {
  std::stable_sort(exchanges.begin(), exchanges.end(),
                   [](const auto& a, const auto& b) { return delay_ns(a) < delay_ns(b); });
  exchanges.resize(std::min(exchanges.size(), std::max<std::size_t>(3, exchanges.size() / 4)));
  std::sort(exchanges.begin(), exchanges.end(),
            [](const auto& a, const auto& b) { return a.t1_ns < b.t1_ns; });
  return exchanges;
}

std::vector<double> residuals_of(const std::vector<OffsetSample>& samples, const OffsetLine& line) {
  std::vector<double> residuals;
  for (const OffsetSample& s : samples)
    residuals.push_back(s.offset_ns - line.slope * static_cast<double>(s.host_ns - line.origin_ns) -
                        line.intercept_ns);
  return residuals;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double median_slope(const std::vector<OffsetSample>& samples) {
  const std::size_t step = std::max<std::size_t>(1, samples.size() / 200);
  const double least_span = static_cast<double>(samples.back().host_ns - samples.front().host_ns) / 3.0;
  std::vector<double> slopes;
  for (std::size_t i = 0; i < samples.size(); i += step)
    for (std::size_t j = i + 1; j < samples.size(); j += step) {
      const double span = static_cast<double>(samples[j].host_ns - samples[i].host_ns);
      if (span > 0.0 && span >= least_span)
        slopes.push_back((samples[j].offset_ns - samples[i].offset_ns) / span);
    }
  return slopes.empty() ? 0.0 : median_of(std::move(slopes));
}

double sigma_of(const std::vector<double>& values, double middle) {
  std::vector<double> deviations;
  for (double value : values) deviations.push_back(std::abs(value - middle));
  return 1.4826 * median_of(std::move(deviations));
}

double sigma_of_median(double sigma, std::size_t count) {
  return 1.2533 * sigma / std::sqrt(static_cast<double>(count));
}

}  // namespace trilat
