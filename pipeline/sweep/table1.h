// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/paper/printed_tables.h"
#include "datasets/results/table.h"
#include "datasets/results/timings.h"
#include "pipeline/sweep/sweep_summary.h"

namespace trilat {

// The readings of one table: alike in all but gradient and stop rule.
struct Table1Readings {
  std::string name;                       // what they share
  std::optional<std::size_t> as_printed;  // eq. 17 and eq. 19 as they stand: errata E7 and E8
  std::optional<std::size_t> printed;     // eq. 17 as printed, |F_k - F_{k-1}| < C
  std::optional<std::size_t> corrected;   // J^T f, |F_k - F_{k-1}| < C
  bool complete() const { return printed && corrected; }
};

// The readings that get a table: none where the sweep has many readings, or thresholds or error ranges that
// are not the paper's.
std::vector<Table1Readings> table1_readings(const SweepSummary& summary, const PrintedTable1& paper);

// The paper's Table I beside ours, one table for each reading that was run with the printed and with the
// corrected gradient: propagation error, iterations and, in a sweep with time_problems, time of a solve.
// Empty when the sweep's thresholds or error ranges are not the paper's.
std::vector<Table> table1(const SweepSummary& summary, const SweepTimings& timings);

}  // namespace trilat
