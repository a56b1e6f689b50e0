// SPDX-License-Identifier: MIT
#include "reports/parameters_table.h"

#include <algorithm>

#include <fmt/format.h>

namespace trilat {

Table parameters_table(const std::vector<DeclaredParameter>& parameters, const std::string& studies) {
  Table table;
  table.id = "simulator";
  table.title = fmt::format("What the simulation behind {} assumes, with sources", studies);
  table.columns = {{"parameter", "name", true},
                   {"value", "value", true},
                   {"unit", "unit", true},
                   {"source", "source", true}};
  for (const DeclaredParameter& p : parameters)
    table.rows.push_back(
        {TableValue::of(p.name), TableValue::of(p.value), TableValue::of(p.unit), TableValue::of(p.source)});
  const bool any_set = std::any_of(parameters.begin(), parameters.end(), [](const DeclaredParameter& p) {
    return p.source == kSetInTheSimulation;
  });
  if (!any_set)
    table.notes = {
        "Values were declared before any result was looked at, and none was fitted to the paper's tables."};
  return table;
}

}  // namespace trilat
