// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "datasets/base/document.h"
#include "reports/embedded_recorded.h"
#include "reports/tables/tables.h"

namespace trilat {

Table recorded_table() { return read_as<Table>(Json::parse(embedded::recorded_json), {"recorded.json"}); }

}  // namespace trilat
