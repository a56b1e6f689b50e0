// SPDX-License-Identifier: MIT
#include "datasets/results/tracking_summary.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"
#include "datasets/results/tracking_rows.h"

namespace trilat {
namespace {

constexpr const char* kFormat = "trilat.tracking";

RangeRow read_range_row(JsonObject& object) {
  RangeRow row{object.text("condition"), object.text("group"), object.count("n"),
               number_or_nan(object, "mean_error_m"), number_or_nan(object, "rms_error_m")};
  object.finish();
  return row;
}

}  // namespace

void write_tracking_summary(const std::filesystem::path& folder, const TrackingSummary& s) {
  Json json{{"format", kFormat},          {"version", 1},           {"study", s.study},
            {"simulated", s.simulated},   {"repaired", s.repaired}, {"views", Json::array()},
            {"exchanges", Json::array()}, {"clocks", Json::array()}};
  for (const ViewRow& row : s.views) json["views"].push_back(json_of(row));
  for (const ExchangeRow& row : s.exchanges) json["exchanges"].push_back(json_of(row));
  for (const ClockRow& row : s.clocks) json["clocks"].push_back(json_of(row));
  json["ranges"] = Json::array();
  for (const RangeRow& row : s.ranges)
    json["ranges"].push_back({{"condition", row.condition},
                              {"group", row.group},
                              {"n", row.n},
                              {"mean_error_m", row.mean_error_m},
                              {"rms_error_m", row.rms_error_m}});
  write_file(folder / "tracking.json", json_text(json, 1) + "\n");
}

std::optional<TrackingSummary> read_tracking_summary(const std::filesystem::path& folder) {
  const auto path = folder / "tracking.json";
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Json json = read_json(path);
  JsonObject object(json, path.string(), "");
  check_format(object, kFormat, 1);
  TrackingSummary s;
  s.study = object.text("study");
  s.simulated = object.boolean("simulated", false);
  s.repaired = object.boolean("repaired", false);
  for (JsonObject& row : object.objects("views")) s.views.push_back(read_view(row));
  for (JsonObject& row : object.objects("exchanges")) s.exchanges.push_back(read_exchange(row));
  for (JsonObject& row : object.objects("clocks")) s.clocks.push_back(read_clock(row));
  for (JsonObject& row : object.objects("ranges")) s.ranges.push_back(read_range_row(row));
  object.finish();
  return s;
}

}  // namespace trilat
