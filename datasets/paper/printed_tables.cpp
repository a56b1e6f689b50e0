// SPDX-License-Identifier: MIT
#include "datasets/paper/printed_tables.h"

#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"
#include "datasets/paper/embedded_paper.h"

namespace trilat {

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
