// SPDX-License-Identifier: MIT
#include "reports/tables/budget_parts.h"

#include <cmath>

namespace trilat {

double rmse_of_source_m(const BudgetSummary& s, const BudgetRow& like, const std::string& source) {
  for (const BudgetRow& row : s.rows)
    if (row.source == source && row.method == like.method && row.condition == like.condition &&
        row.group == like.group && row.alignment == like.alignment)
      return row.rmse_m;
  return kNoNumber;
}

double added_m2(const BudgetSummary& s, const BudgetRow& like, const std::string& source) {
  const double floor_m2 = std::pow(rmse_of_source_m(s, like, "none"), 2);
  return source == "none" ? floor_m2 : std::pow(rmse_of_source_m(s, like, source), 2) - floor_m2;
}

double sum_of_sources_m(const BudgetSummary& s, const BudgetRow& like) {
  double sum_m2 = added_m2(s, like, "none");
  for (const std::string& source : s.sources)
    if (source != "none" && source != "all") sum_m2 += added_m2(s, like, source);
  return sum_m2 < 0.0 ? 0.0 : std::sqrt(sum_m2);
}

}  // namespace trilat
