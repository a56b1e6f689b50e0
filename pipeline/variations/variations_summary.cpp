// SPDX-License-Identifier: MIT
#include "pipeline/variations/variations_summary.h"

#include <cmath>

#include <fmt/format.h>

namespace trilat {

double VariedRange::value_at(double position) const {
  if (!values.empty()) {
    const auto count = static_cast<double>(values.size());
    return std::min(std::floor(position * count), count - 1.0);
  }
  if (whole) return std::min(low + std::floor(position * (high - low + 1.0)), high);
  if (logarithmic) return low * std::pow(high / low, position);
  return low + position * (high - low);
}

std::string VariedRange::text_at(double position) const {
  const double value = value_at(position);
  return values.empty() ? fmt::format("{:.4g}", value) : values[static_cast<std::size_t>(value)];
}

double MethodComparison::difference_percent(const std::vector<std::string>& methods,
                                            const VariationPoint& point, std::size_t alignment) const {
  if (point.paired_m.empty()) return kNoNumber;
  const auto paired_m = [&](const std::string& method, const std::string& with) {
    const auto index = [&](const std::string& of) {
      return static_cast<std::size_t>(std::ranges::find(methods, of) - methods.begin());
    };
    return point.paired_m[(alignment * methods.size() + index(method)) * methods.size() + index(with)];
  };
  double most = kNoNumber;
  for (const std::string& other : than)
    most = std::fmax(most, paired_m(better, other) / paired_m(other, better));
  return 100.0 * (most / (1.0 + 0.01 * margin_percent) - 1.0);
}

void VariationsSummary::check(const JsonObject& object) const {
  for (const VariationPoint& p : points)
    if (p.position.size() != ranges.size() ||
        (p.problem.empty() && (p.answered.size() != methods.size() || p.person_m.size() != methods.size() ||
                               p.paired_m.size() != alignments.size() * methods.size() * methods.size())))
      object.refuse("points",
                    "must have a number for each range, each method, and each alignment and pair of methods");
}

}  // namespace trilat
