// SPDX-License-Identifier: MIT
#include "datasets/results/studies/tracking_summary.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"

namespace trilat {

namespace {

constexpr const char* kFormat = "trilat.tracking";

RangeRow read_range_row(JsonObject& object) {
  RangeRow row{object.text("condition"), object.text("group"), object.count("n"),
               number_or_nan(object, "mean_error_m"), number_or_nan(object, "rms_error_m")};
  object.finish();
  return row;
}

constexpr std::pair<const char*, double PredictionRow::*> kPredictionNumbers[] = {
    {"range_m", &PredictionRow::range_m},
    {"range_low_m", &PredictionRow::range_low_m},
    {"range_high_m", &PredictionRow::range_high_m},
    {"bearing_m", &PredictionRow::bearing_m},
    {"bearing_low_m", &PredictionRow::bearing_low_m},
    {"bearing_high_m", &PredictionRow::bearing_high_m},
    {"mean_range_m", &PredictionRow::mean_range_m}};

Json json_of(const PredictionRow& row) {
  Json json{{"condition", row.condition}, {"method", row.method}, {"n", row.n}};
  for (const auto& [key, member] : kPredictionNumbers) json[key] = row.*member;
  return json;
}

PredictionRow read_prediction(JsonObject& object) {
  PredictionRow row{
      .condition = object.text("condition"), .method = object.text("method"), .n = object.count("n")};
  for (const auto& [key, member] : kPredictionNumbers) row.*member = number_or_nan(object, key);
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
  json["rays"] = Json::array();
  for (const RayRow& row : s.rays) json["rays"].push_back(json_of(row));
  json["predictions"] = Json::array();
  for (const PredictionRow& row : s.predictions) json["predictions"].push_back(json_of(row));
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
  for (JsonObject& row : object.objects("rays")) s.rays.push_back(read_ray(row));
  for (JsonObject& row : object.objects("predictions")) s.predictions.push_back(read_prediction(row));
  object.finish();
  return s;
}

namespace {

constexpr std::pair<const char*, double RayRow::*> kRayNumbers[] = {{"range_m", &RayRow::range_m},
                                                                    {"bearing_m", &RayRow::bearing_m},
                                                                    {"ratio", &RayRow::ratio},
                                                                    {"ratio_low", &RayRow::ratio_low},
                                                                    {"ratio_high", &RayRow::ratio_high}};

}  // namespace

Json json_of(const RayRow& row) {
  Json json{{"take", row.take}, {"rows", row.rows}, {"problem", row.problem}};
  for (const auto& [key, member] : kRayNumbers) json[key] = row.*member;
  return json;
}

RayRow read_ray(JsonObject& object) {
  RayRow row{.take = object.text("take"), .rows = object.count("rows"), .problem = object.text("problem")};
  for (const auto& [key, member] : kRayNumbers) row.*member = number_or_nan(object, key);
  object.finish();
  return row;
}

Json json_of(const ViewRow& row) {
  Json json{{"condition", row.condition}, {"sensor", row.sensor}, {"group", row.group},
            {"rule", row.rule},           {"views", row.views},   {"rejected", row.rejected}};
  if (row.truth_known) json.update({{"hidden", row.hidden}, {"rightly", row.rightly}});
  return json;
}

ViewRow read_view(JsonObject& object) {
  ViewRow row;
  row.condition = object.text("condition");
  row.sensor = object.text("sensor");
  row.group = object.text("group");
  row.rule = object.text("rule");
  row.views = object.count("views");
  row.rejected = object.count("rejected");
  row.truth_known = object.has("hidden");
  if (row.truth_known) {
    row.hidden = object.count("hidden");
    row.rightly = object.count("rightly");
  }
  object.finish();
  if (row.rejected > row.views) object.refuse("rejected", "are more than the views");
  if (row.hidden > row.views) object.refuse("hidden", "are more than the views");
  if (row.truth_known && (row.rightly > row.rejected || row.rightly > row.hidden))
    object.refuse("rightly", "are more than were rejected, or than are hidden");
  return row;
}

Json json_of(const ExchangeRow& row) {
  Json json{{"condition", row.condition},
            {"sensor", row.sensor},
            {"instants", row.instants},
            {"found", row.found},
            {"stretches", row.stretches}};
  if (row.truth_known)
    json.update({{"exchanged", row.exchanged},
                 {"rightly", row.rightly},
                 {"true_stretches", row.true_stretches},
                 {"stretches_found", row.stretches_found}});
  return json;
}

ExchangeRow read_exchange(JsonObject& object) {
  ExchangeRow row;
  row.condition = object.text("condition");
  row.sensor = object.text("sensor");
  row.instants = object.count("instants");
  row.found = object.count("found");
  row.stretches = object.count("stretches");
  row.truth_known = object.has("exchanged");
  if (row.truth_known) {
    row.exchanged = object.count("exchanged");
    row.rightly = object.count("rightly");
    row.true_stretches = object.count("true_stretches");
    row.stretches_found = object.count("stretches_found");
  }
  object.finish();
  if (row.found > row.instants) object.refuse("found", "are more than the instants");
  if (!row.truth_known) return row;
  if (row.exchanged > row.instants) object.refuse("exchanged", "are more than the instants");
  if (row.rightly > row.found || row.rightly > row.exchanged)
    object.refuse("rightly", "are more than were found, or than are exchanged");
  if (row.found - row.rightly > row.instants - row.exchanged)
    object.refuse("found", "and not exchanged are more than the instants that are not");
  if (row.stretches_found > row.true_stretches)
    object.refuse("stretches_found", "are more than the true stretches");
  return row;
}

Json json_of(const ClockRow& row) {
  return {{"take", row.take},
          {"status", row.status},
          {"offset_s", row.offset_s},
          {"low_s", row.low_s},
          {"high_s", row.high_s},
          {"drift_ppm", row.drift_ppm},
          {"drift_sigma_ppm", row.drift_sigma_ppm},
          {"peak", row.peak},
          {"second", row.second},
          {"applied", row.applied}};
}

ClockRow read_clock(JsonObject& object) {
  ClockRow row;
  row.take = object.text("take");
  row.status = object.text("status");
  row.offset_s = number_or_nan(object, "offset_s");
  row.low_s = number_or_nan(object, "low_s");
  row.high_s = number_or_nan(object, "high_s");
  row.drift_ppm = number_or_nan(object, "drift_ppm");
  row.drift_sigma_ppm = number_or_nan(object, "drift_sigma_ppm");
  row.peak = number_or_nan(object, "peak");
  row.second = number_or_nan(object, "second");
  row.applied = object.boolean("applied", false);
  object.finish();
  return row;
}

}  // namespace trilat
