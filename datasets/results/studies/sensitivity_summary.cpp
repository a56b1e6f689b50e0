// SPDX-License-Identifier: MIT
#include "datasets/results/studies/sensitivity_summary.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/text_output.h"

namespace trilat {
namespace {

void write_points(const std::filesystem::path& path, const SensitivitySummary& s) {
  TextOutput text(path);
  text.add("design,row");
  for (const SensitivityFactor& factor : s.factors) text.add(",{}", csv_field(factor.name));
  text.add(",method,mae_m,answered,problem\n");
  for (const SensitivityPoint& point : s.points)
    for (std::size_t m = 0; m < s.methods.size(); ++m) {
      text.add("{},{}", csv_field(point.design), point.row);
      for (std::size_t f = 0; f < s.factors.size(); ++f)
        text.add(",{}", std::isfinite(point.position[f]) ? csv_field(s.text_at(f, point.position[f])) : "");
      text.add(",{}", csv_field(s.methods[m]));
      for (const double number : {point.paired_m[m * s.methods.size() + m], point.answered[m]})
        if (std::isfinite(number))
          text.add(",{:.9g}", number);
        else
          text.add(",");
      text.add(",{}\n", csv_field(point.problem));
    }
  text.publish();
}

}  // namespace

double SensitivitySummary::value_at(std::size_t factor, double position) const {
  const SensitivityFactor& f = factors[factor];
  if (!f.values.empty()) {
    const auto count = static_cast<double>(f.values.size());
    return std::min(std::floor(position * count), count - 1.0);
  }
  if (f.whole) return std::min(f.low + std::floor(position * (f.high - f.low + 1.0)), f.high);
  if (f.logarithmic) return f.low * std::pow(f.high / f.low, position);
  return f.low + position * (f.high - f.low);
}

std::string SensitivitySummary::text_at(std::size_t factor, double position) const {
  const double value = value_at(factor, position);
  if (factors[factor].values.empty()) return fmt::format("{:.4g}", value);
  return factors[factor].values[static_cast<std::size_t>(value)];
}

double difference_percent(const SensitivityClaim& claim, const std::vector<std::string>& methods,
                          const SensitivityPoint& point, std::size_t alignment) {
  const auto paired_m = [&](const std::string& method, const std::string& with) {
    const auto index = [&](const std::string& name) {
      return static_cast<std::size_t>(std::ranges::find(methods, name) - methods.begin());
    };
    return point.paired_m[(alignment * methods.size() + index(method)) * methods.size() + index(with)];
  };
  double most = kNoNumber;
  for (const std::string& name : claim.than)
    most = std::fmax(most, paired_m(claim.better, name) / paired_m(name, claim.better));
  return 100.0 * (most / (1.0 + 0.01 * claim.margin_percent) - 1.0);
}

void SensitivitySummary::check(const JsonObject& object) const {
  if (alignments.empty()) object.refuse("alignments", "must hold one at least");
  for (const SensitivityPoint& p : points)
    if (p.position.size() != factors.size() || p.answered.size() != methods.size() ||
        p.paired_m.size() != alignments.size() * methods.size() * methods.size())
      object.refuse(
          "points",
          "must have a number for each factor, each method, and each alignment and pair of methods");
}

void write_sensitivity_summary(const std::filesystem::path& folder, const SensitivitySummary& summary) {
  write_points(folder / "points.csv", summary);
  write_results(folder, summary);
}

SensitivitySummary read_sensitivity_summary(const std::filesystem::path& folder) {
  return read_results<SensitivitySummary>(folder);
}

}  // namespace trilat
