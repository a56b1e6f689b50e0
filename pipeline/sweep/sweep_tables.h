// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/base/json.h"
#include "datasets/paper/printed_tables.h"
#include "datasets/results/figure.h"
#include "datasets/results/results_file.h"
#include "datasets/results/table.h"
#include "pipeline/sweep/sweep_spec.h"
#include "pipeline/sweep/sweep_summary.h"

namespace trilat {

// Times measured on this machine.
struct SweepTimings {
  static constexpr const char* kFile = "timings.json";
  std::string study;
  std::string processor;
  // Problems of each cell that the scalar solver solved on one thread, the fastest of three times; 0: all
  // trials, made and solved as the run took them.
  std::uint64_t problems = 0;
  std::vector<double> solve_us;  // a solve, start included; of each cell of the summary, in its order

  static void fields(auto& self, auto&& f) {
    f.format("trilat.timings");
    f("study", self.study, "processor", self.processor, "problems", self.problems, "solve_us", self.solve_us);
  }
};

// Tables of a sweep: the paper's Table I beside ours, and every cell.
StoredTables sweep_tables(const SweepSummary& summary, const SweepTimings& timings);

// Error, steps, share of answers and, with time_problems, time over the threshold C: a panel for each rig,
// error model and range of errors, a line for each other choice. With the paper's grid its Table I stands
// beside.
std::vector<Figure> sweep_figures(const SweepSummary& summary, const SweepTimings& timings);

// The interpretations of one table: alike in all but gradient and stop rule.
struct Table1Interpretations {
  std::string name;                       // what they share
  std::optional<std::size_t> as_printed;  // eq. 17 and eq. 19 as they stand: errata E7 and E8
  std::optional<std::size_t> printed;     // eq. 17 as printed, |F_k - F_{k-1}| < C
  std::optional<std::size_t> corrected;   // J^T f, |F_k - F_{k-1}| < C
  bool complete() const { return printed && corrected; }
};

// The interpretations that get a table: none where the sweep has many interpretations, or thresholds or error
// ranges that are not the paper's.
std::vector<Table1Interpretations> table1_interpretations(const SweepSummary& summary,
                                                          const PrintedTable1& paper);

// The paper's Table I beside ours, one table for each interpretation that was run with the printed and with
// the corrected gradient: propagation error, iterations and, in a sweep with time_problems, time of a solve.
std::vector<Table> table1(const SweepSummary& summary, const SweepTimings& timings);

// With the paper's grid adds the share of interpretations ("interpretations") in which C = 1e-4 is a
// compromise, of those whose every error is within a factor of 2 of the printed one with nine trials in ten
// answered: a smaller threshold takes twice the steps, and the largest errs by a tenth more. None where no
// interpretation is so near.
void add_interpretations(SweepSummary& summary);

// "error model" of error_model.
std::string heading_of(const SweepChoice& choice);

}  // namespace trilat
