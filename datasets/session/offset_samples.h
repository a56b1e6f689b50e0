// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "datasets/session/session_types.h"

namespace trilat {

// What one exchange says of agent - host, taking its delays as alike both ways.
struct OffsetSample {
  std::int64_t host_ns = 0;  // midpoint of the exchange on the host
  double offset_ns = 0.0;    // less a base of the caller's
};

std::int64_t twice_offset_ns(const ClockExchange& exchange);
std::vector<OffsetSample> samples_of(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns);

// The quarter of least delay, but three at least, by t1: those that queueing disturbed least.
std::vector<ClockExchange> least_delayed(std::vector<ClockExchange> exchanges);

// offset = intercept + slope (host - origin)
struct OffsetLine {
  std::int64_t origin_ns = 0;
  double intercept_ns = 0.0;
  double slope = 0.0;
};
std::vector<double> residuals_of(const std::vector<OffsetSample>& samples, const OffsetLine& line);

// Median of the slopes between samples at least a third of the span apart; bounded work for long
// recordings. Samples by time.
double median_slope(const std::vector<OffsetSample>& samples);

double median_of(std::vector<double> values);  // the upper one of an even number; at least one
// Standard deviation of normal values with this median absolute deviation from `middle`.
double sigma_of(const std::vector<double>& values, double middle);
// Of the median of `count` normal values.
double sigma_of_median(double sigma, std::size_t count);

}  // namespace trilat
