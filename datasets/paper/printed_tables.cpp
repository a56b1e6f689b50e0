// SPDX-License-Identifier: MIT
#include "datasets/paper/printed_tables.h"

#include <limits>

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

PrintedCalibration printed_calibration() {
  const Json json = parse_json(embedded::calibration_json, "datasets/paper/calibration.json");
  JsonObject object(json, "datasets/paper/calibration.json", "");
  PrintedCalibration paper;
  paper.source = object.text("source");
  paper.samples = static_cast<int>(object.integer("samples"));
  JsonObject recommended = object.object("recommended");
  const std::vector<double> distance_m = recommended.numbers("distance_m", 2);
  paper.recommended_m = {distance_m[0], distance_m[1]};
  paper.recommended_below_deg = recommended.number("below_angle_deg");
  paper.recommended_samples = static_cast<int>(recommended.integer("samples"));
  paper.recommended_mean_cm = recommended.number("mean_error_cm");
  paper.recommended_spread_cm = recommended.number("spread_cm");
  JsonObject near = object.object("near");
  paper.near_m = near.number("nearer_than_m");
  paper.near_valid_percent = near.number("valid_percent");
  JsonObject distortion = object.object("distortion");
  paper.wall_m = distortion.number("wall_m");
  paper.wall_frames = static_cast<int>(distortion.integer("frames"));
  for (const Json& range : distortion.value("worse_columns"))
    paper.worse_columns.push_back({range.at(0).get<double>(), range.at(1).get<double>()});
  paper.worse = distortion.text("worse");
  return paper;
}

PrintedTable2 printed_table2() {
  const Json json = parse_json(embedded::table2_json, "datasets/paper/table2.json");
  JsonObject object(json, "datasets/paper/table2.json", "");
  PrintedTable2 table;
  table.source = object.text("source");
  for (JsonObject& row : object.objects("rows"))
    table.rows.push_back({row.text("part"), row.text("condition"), row.texts("groups"), row.number("with_cm"),
                          row.number("without_cm")});
  return table;
}

PrintedTable4 printed_table4() {
  const Json json = parse_json(embedded::table4_json, "datasets/paper/table4.json");
  JsonObject object(json, "datasets/paper/table4.json", "");
  PrintedTable4 table;
  table.source = object.text("source");
  table.frames = object.count("frames");
  table.clients = object.count("clients");
  for (JsonObject& row : object.objects("rows"))
    table.rows.push_back(
        {row.number("from_ms"),
         row.value("to_ms").is_null() ? std::numeric_limits<double>::infinity() : row.number("to_ms"),
         row.count("frames"), row.count("clock_samples")});
  table.lost_frames = object.count("lost_frames");
  table.real_time_percent = object.number("real_time_percent");
  table.below_2ms_percent = object.number("below_2ms_percent");
  return table;
}

Json printed_claims() { return parse_json(embedded::claims_json, "datasets/paper/claims.json"); }

PrintedErrata printed_errata() {
  const Json json = parse_json(embedded::errata_json, "datasets/paper/errata.json");
  JsonObject object(json, "datasets/paper/errata.json", "");
  PrintedErrata errata;
  errata.source = object.text("source");
  for (JsonObject& e : object.objects("errata"))
    errata.errata.push_back({e.text("id"), e.text("where"), e.text("printed"), e.text("problem"),
                             e.text("corrected"), e.boolean("changes_results", true),
                             e.has("effect") ? e.value("effect") : Json()});
  JsonObject improvement = object.object("improvement_percent");
  for (const std::string& where : improvement.keys()) {
    JsonObject by_method = improvement.object(where);
    for (const std::string& method : by_method.keys())
      errata.improvements.push_back({where, method, by_method.number(method)});
  }
  errata.largest_wrist_deviation_cm = object.number("largest_wrist_deviation_cm");
  const std::vector<double> cycles = object.numbers("gait_cycles", 2);
  errata.gait_cycles = {cycles[0], cycles[1]};
  JsonObject systems = object.object("systems");
  errata.systems_named = systems.number("named");
  errata.systems_shown = systems.number("shown");
  return errata;
}

}  // namespace trilat
