// SPDX-License-Identifier: MIT
#include "datasets/paper/printed_tables.h"

#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"
#include "datasets/paper/embedded_paper.h"

namespace trilat {

PrintedTable1 printed_table1() {
  const Json json = parse_json(embedded::table1_json, "datasets/paper/table1.json");
  JsonObject object(json, "datasets/paper/table1.json", "");
  PrintedTable1 table;
  table.source = object.text("source");
  for (const Json& range : object.value("error_ranges_cm"))
    table.ranges_cm.push_back({range.at(0).get<double>(), range.at(1).get<double>()});
  for (JsonObject& row : object.objects("rows"))
    table.rows.push_back({row.number("threshold"), row.numbers("error_cm", table.ranges_cm.size()),
                          row.numbers("time_us", table.ranges_cm.size()),
                          row.boolean("time_is_below", false)});
  return table;
}

PrintedTable3 printed_table3() {
  const Json json = parse_json(embedded::table3_json, "datasets/paper/table3.json");
  JsonObject object(json, "datasets/paper/table3.json", "");
  PrintedTable3 table;
  table.source = object.text("source");
  table.methods = object.texts("methods");
  for (JsonObject& row : object.objects("rows"))
    table.rows.push_back({row.text("group"), row.numbers("mae_cm", table.methods.size())});
  return table;
}

}  // namespace trilat
