// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "datasets/base/described.h"
#include "reports/embedded_recorded.h"
#include "reports/tables/tables.h"

namespace trilat {

Table recorded_table() {
  const Json json = Json::parse(embedded::recorded_json);
  JsonObject object(json, "recorded.json", "");
  Table table;
  read_fields(object, table);
  return table;
}

}  // namespace trilat
