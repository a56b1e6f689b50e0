// SPDX-License-Identifier: MIT
#include "reports/tables/calibration_findings.h"

#include <algorithm>
#include <cmath>

#include "datasets/base/units.h"

namespace trilat {
namespace {

// Where the paper sees the error grow: columns 0 to 149 and 351 to the last.
constexpr std::size_t kMiddleFrom = 150, kMiddleTo = 350;

struct Mean {
  double sum = 0.0, n = 0.0;
  void add(double value) {
    if (!std::isfinite(value)) return;
    sum += value;
    n += 1.0;
  }
  double value() const { return n > 0.0 ? sum / n : ErrorSpread::kNone; }
};

}  // namespace

const WandRow* wand_row(const CalibrationSummary& summary, const std::string& method,
                        const std::string& scene) {
  for (const WandRow& row : summary.wand)
    if (row.method == method && row.scene == scene) return &row;
  return nullptr;
}

const RigRow* rig_row(const CalibrationSummary& summary, const std::string& method) {
  for (const RigRow& row : summary.rigs)
    if (row.method == method) return &row;
  return nullptr;
}

std::vector<EffectRow> assumed_effects(const CalibrationSummary& summary, const std::string& method) {
  std::vector<EffectRow> rows;
  for (const EffectRow& row : summary.effect)
    if (row.method == method && (row.calibration == "exact" || row.calibration.ends_with(" mm an axis")))
      rows.push_back(row);
  std::stable_sort(rows.begin(), rows.end(), [](const EffectRow& a, const EffectRow& b) {
    return a.sensor_sigma_m < b.sensor_sigma_m;
  });
  return rows;
}

ColumnMeans column_means(const std::vector<double>& by_column) {
  Mean left, middle, right, edge;
  for (std::size_t c = 0; c < by_column.size(); ++c) {
    const bool is_left = c<kMiddleFrom, is_right = c> kMiddleTo;
    (is_left ? left : is_right ? right : middle).add(by_column[c]);
    if (is_left || is_right) edge.add(by_column[c]);
  }
  return {left.value(), middle.value(), right.value(), edge.value()};
}

std::optional<double> sensor_sigma_m_at(const CalibrationSummary& summary, double factor) {
  const std::vector<EffectRow> rows = assumed_effects(summary, "nonlinear");
  if (rows.empty() || rows.front().sensor_sigma_m != 0.0) return std::nullopt;
  const double wanted_m2 = std::pow(factor * rows.front().rmse_m, 2);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double from_m2 = std::pow(rows[i - 1].rmse_m, 2), to_m2 = std::pow(rows[i].rmse_m, 2);
    if (!(from_m2 < wanted_m2 && wanted_m2 <= to_m2)) continue;
    const double from_sigma_m2 = std::pow(rows[i - 1].sensor_sigma_m, 2);
    const double to_sigma_m2 = std::pow(rows[i].sensor_sigma_m, 2);
    return std::sqrt(from_sigma_m2 +
                     (wanted_m2 - from_m2) / (to_m2 - from_m2) * (to_sigma_m2 - from_sigma_m2));
  }
  return std::nullopt;
}

}  // namespace trilat
