// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/results/summary.h"

namespace trilat {

// The numbers of one condition, group, method and alignment that tests look at.
struct ErrorCell {
  NumberKey key;
  std::string method, group, alignment;
  std::uint64_t asked = 0, answered = 0, clusters = 0;
  double mae_m = kNaN, mae_low_m = kNaN, mae_high_m = kNaN, rmse_m = kNaN, max_m = kNaN;
  double coverage() const { return static_cast<double>(answered) / static_cast<double>(asked); }
};

inline ErrorCell cell_of(const Numbers& numbers, const Number& asked) {
  const auto of = [&](const char* statistic) {
    const Number* number = numbers.find(asked.with({.measure = "distance", .statistic = statistic}));
    return number ? *number : Number{};
  };
  const Number mean = of("mean");
  return {asked,         asked.method, asked.group, asked.alignment, asked.n,         mean.n,
          mean.clusters, mean.value,   mean.low,    mean.high,       of("rms").value, of("max").value};
}

// In the order of the study's numbers, averages of groups included.
inline std::vector<ErrorCell> error_cells(const ResultsSummary& summary) {
  std::vector<ErrorCell> cells;
  for (const Number& asked : summary.numbers.all())
    if (asked.measure == "answered" && asked.statistic == "share" && asked.take.empty())
      cells.push_back(cell_of(summary.numbers, asked));
  return cells;
}

inline std::optional<ErrorCell> find_cell(const ResultsSummary& summary, const std::string& method,
                                          const std::string& condition, const std::string& group,
                                          const std::string& alignment) {
  const Number* asked = find_coverage(summary, method, condition, group, alignment);
  return asked ? std::optional(cell_of(summary.numbers, *asked)) : std::nullopt;
}

}  // namespace trilat
