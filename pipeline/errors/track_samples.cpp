// SPDX-License-Identifier: MIT
#include "pipeline/errors/track_samples.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "evaluators/metrics/body_metrics.h"

namespace trilat {
namespace {

// Histogram of the truth's acceleration, in bins of 0.1 m/s2; the last holds all that is larger.
constexpr double kAccelerationBin_m_s2 = 0.1;
constexpr std::uint8_t kBins = 255, kUnknown = 255;
using Accelerations = std::array<std::uint32_t, kBins>;

// Whether the truth is known at the instants from i - before to i + behind.
bool has_truth(const Window& w, std::uint64_t i, std::size_t j, std::uint64_t before, std::uint64_t behind) {
  if (i < w.begins() + before || i + behind >= w.ends()) return false;
  for (std::uint64_t k = i - before; k <= i + behind; ++k)
    if (!w.truth_m(k, j).allFinite()) return false;
  return true;
}

std::uint8_t bin_of_acceleration(const Window& w, std::uint64_t i, std::size_t j, std::uint64_t beside,
                                 double rate_hz) {
  const double step_s = static_cast<double>(beside) / rate_hz;
  const double m_s2 = (w.truth_m(i + beside, j) - 2.0 * w.truth_m(i, j) + w.truth_m(i - beside, j)).norm() /
                      (step_s * step_s);
  return static_cast<std::uint8_t>(std::min(kBins - 1.0, m_s2 / kAccelerationBin_m_s2));
}

// The bin from which on samples are of the half with the larger acceleration.
std::uint8_t half_of(const Accelerations& bins) {
  std::uint64_t all = 0, smaller = 0;
  for (const std::uint32_t n : bins) all += n;
  std::uint8_t bin = 0;
  while (bin < bins.size() && 2 * smaller < all) smaller += bins[bin++];
  return bin;
}

}  // namespace

SampleMarks::SampleMarks(const Windows& windows, const TakeHead& head, double rate_hz)
    : instants_(head.instants),
      marks_(head.joints.size() * head.instants),
      answered_(head.methods.size(), SampleSet(marks_.size())),
      truth_(head.joints.size()) {
  const std::uint64_t beside = instants_beside(rate_hz);
  std::vector<std::uint8_t> acceleration(marks_.size(), kUnknown);
  std::vector<Accelerations> accelerations(truth_.size());
  windows.each([&](const Window& w) {
    for (std::size_t j = 0; j < truth_.size(); ++j) {
      truth_[j].quantity = static_cast<std::uint32_t>(j);
      for (std::uint64_t i = w.first; i < w.end; ++i) {
        if (!has_truth(w, i, j, 0, 0)) continue;
        const std::size_t k = place(i, j);
        marks_[k] = kAsked;
        if (w.block.occluded[w.place(i, j)] > 0) marks_[k] |= kOccluded;
        for (std::size_t m = 0; m < answered_.size(); ++m)
          if (is_usable(w.status(w.slot(i, j, m)))) answered_[m].add(k);
        add_movement(w, i, j, rate_hz);
        if (!has_truth(w, i, j, beside, beside)) continue;
        acceleration[k] = bin_of_acceleration(w, i, j, beside, rate_hz);
        ++accelerations[j][acceleration[k]];
      }
    }
  });
  for (std::size_t j = 0; j < truth_.size(); ++j) {
    const std::uint8_t half = half_of(accelerations[j]);
    for (std::uint64_t i = 0; i < instants_; ++i)
      if (const std::size_t k = place(i, j); acceleration[k] != kUnknown && acceleration[k] >= half)
        marks_[k] |= kAbrupt;
  }
}

std::uint64_t SampleMarks::instants_beside(double rate_hz) {
  constexpr double kBeside_s = 1.0 / 15.0;
  return static_cast<std::uint64_t>(std::max(1LL, std::llround(kBeside_s * rate_hz)));
}

void SampleMarks::add_movement(const Window& w, std::uint64_t i, std::size_t j, double rate_hz) {
  TruthRow& row = truth_[j];
  if (!has_truth(w, i, j, 1, 1)) return;
  ++row.speeds;
  row.speed_m_s += (w.truth_m(i + 1, j) - w.truth_m(i - 1, j)).norm() * rate_hz / 2.0;
  if (!has_truth(w, i, j, 1, 2)) return;
  ++row.jerks;
  row.jerk_m_s3 +=
      jerk_m_s3(w.truth_m(i - 1, j), w.truth_m(i, j), w.truth_m(i + 1, j), w.truth_m(i + 2, j), rate_hz);
}

}  // namespace trilat
