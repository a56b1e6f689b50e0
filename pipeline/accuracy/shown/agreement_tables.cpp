// SPDX-License-Identifier: MIT
// Agreement as biomechanics prints it.
#include <array>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "evaluators/metrics/agreement.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/shown/accuracy_words.h"

namespace trilat {
namespace {

constexpr std::array kAxisNames{"x", "y", "z"};

Agreement agreement_of(const CellSums& cell, std::size_t axis) {
  const ClusterSums &sums = cell.error_m.at(axis), &squares = cell.error_m2.at(axis);
  std::vector<DifferenceSums> persons;
  for (std::size_t k = 0; k < sums.n.size(); ++k)
    persons.push_back({sums.n[k], kCentimetresPerMetre * sums.sum[k],
                       kCentimetresPerMetre * kCentimetresPerMetre * squares.sum[k]});
  return limits_of_agreement(persons);
}

}  // namespace

Table agreement_table(const StudyErrors& errors, const std::string& condition, std::size_t alignment) {
  const ResultsSummary& s = errors.names();
  const ConditionErrors in = errors.in(condition);
  Table table{
      usable_id(fmt::format("agreement-{}-{}", condition, s.alignments[alignment])),
      fmt::format("Agreement with the truth by axis: bias and 95 % limits ({}, {}, {}; alignment: {})",
                  s.campaign, condition, s.simulated ? "simulated sensors" : "recorded",
                  s.alignments[alignment]),
      {{"method", "method", true, false},
       {"joint group", "group", true, false},
       {"axis", "axis", true, false},
       interval_column("bias (cm)", "bias_cm"),
       interval_column("lower limit (cm)", "lower_limit_cm"),
       interval_column("upper limit (cm)", "upper_limit_cm"),
       {"sd of a difference (cm)", "sd_cm"}},
      {},
      {}};
  for (std::size_t m = 0; m < s.methods.size(); ++m)
    for (const std::size_t g : in.groups())
      for (std::size_t axis = 0; axis < kAxisNames.size(); ++axis) {
        const Agreement a = agreement_of(in.cell(g, m, alignment), axis);
        table.rows.push_back({TableValue::of(s.methods[m]), TableValue::of(s.groups[g]),
                              TableValue::of(kAxisNames.at(axis)),
                              number_cell(1, a.bias, a.bias_low, a.bias_high),
                              number_cell(1, a.lower, a.lower_low, a.lower_high),
                              number_cell(1, a.upper, a.upper_low, a.upper_high), number_cell(1, a.sd)});
      }
  table.notes = {
      fmt::format("Estimate minus truth along the world's axes. Limits hold 95 % of single differences "
                  "(Bland and Altman 1999, repeated measurements); repeated are those of {}.",
                  in.clusters())};
  return table;
}

std::vector<Table> agreement_tables(const StudyErrors& errors) {
  std::vector<Table> tables;
  for (const std::string& condition : errors.names().conditions)
    for (std::size_t a = 0; a < errors.names().alignments.size(); ++a)
      if (errors.names().alignments[a] == "none" || errors.names().alignments[a] == "mean")
        tables.push_back(agreement_table(errors, condition, a));
  return tables;
}

}  // namespace trilat
