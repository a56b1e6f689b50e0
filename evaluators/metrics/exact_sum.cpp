// SPDX-License-Identifier: MIT
#include "evaluators/metrics/exact_sum.h"

#include <cmath>
#include <cstddef>
#include <utility>

namespace trilat {

// GROW-EXPANSION, leaving out parts that are zero.
void ExactSum::add(double term) {
  if (!std::isfinite(term)) {
    not_finite_ += term;
    return;
  }
  std::size_t kept = 0;
  for (double part : parts_) {
    if (std::abs(term) < std::abs(part)) std::swap(term, part);
    const double sum = term + part;
    if (!std::isfinite(sum)) {
      not_finite_ += sum;
      return;
    }
    const double lost = part - (sum - term);
    if (lost != 0.0) parts_[kept++] = lost;
    term = sum;
  }
  parts_.resize(kept);
  if (term != 0.0) parts_.push_back(term);
}

void ExactSum::add(const ExactSum& other) {
  for (const double part : other.parts()) add(part);
}

double ExactSum::value() const {
  if (not_finite_ != 0.0) return not_finite_;
  double high = 0.0, low = 0.0;
  std::size_t below = parts_.size();
  while (below > 0 && low == 0.0) {
    const double part = parts_[--below], sum = high + part;
    low = part - (sum - high);
    high = sum;
  }
  // `low` may be half a unit in the last place of `high`: then what is below it says where to round.
  if (below > 0 && std::signbit(low) == std::signbit(parts_[below - 1])) {
    const double rounded_away = high + 2.0 * low;
    if (rounded_away - high == 2.0 * low) return rounded_away;
  }
  return high;
}

std::vector<double> ExactSum::parts() const {
  std::vector<double> parts = parts_;
  if (not_finite_ != 0.0) parts.push_back(not_finite_);
  return parts;
}

}  // namespace trilat
