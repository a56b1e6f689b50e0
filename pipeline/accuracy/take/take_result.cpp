// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/take_result.h"

#include <nlohmann/json.hpp>

#include "datasets/results/studies/tracking_summary.h"
#include "pipeline/accuracy/take/solve_block.h"

namespace trilat {
namespace {

Json json_of(const TakeInput& input) {
  return {{"role", input.role},
          {"file", input.file},
          {"bytes", input.bytes},
          {"sha256", input.sha256.empty() ? Json() : Json(input.sha256)}};
}

Json json_of(const TakeCheck& check) {
  return {{"samples", check.samples},
          {"disagreements", check.disagreements},
          {"worst_m", check.worst_m},
          {"worst_at", check.worst_at},
          {"disagreed_at", check.disagreed_at}};
}

Json json_of(const TakeTracking& tracking) {
  Json json{{"views", Json::array()}, {"exchanges", Json::array()}, {"ranges", Json::array()}};
  for (const ViewRow& row : tracking.views) json["views"].push_back(json_of(row));
  for (const ExchangeRow& row : tracking.exchanges) json["exchanges"].push_back(json_of(row));
  for (const RangeSums& sums : tracking.ranges)
    json["ranges"].push_back({{"condition", sums.condition},
                              {"group", sums.group},
                              {"n", sums.n},
                              {"sum_m", sums.sum_m},
                              {"squares_m2", sums.squares_m2}});
  json["predictions"] = Json::array();
  for (const PredictionSums& sums : tracking.predictions)
    json["predictions"].push_back({{"participant", sums.participant},
                                   {"condition", sums.condition},
                                   {"method", sums.method},
                                   {"n", sums.n},
                                   {"range_m", sums.range_m},
                                   {"abs_range_m", sums.abs_range_m},
                                   {"bearing_m", sums.bearing_m}});
  json["clock"] = json_of(tracking.clock);
  json["rays"] = json_of(tracking.rays);
  return json;
}

TakeInput read_input(JsonObject& object) {
  TakeInput input{object.text("role"), object.text("file"), object.count("bytes"), {}};
  if (!object.value("sha256").is_null()) input.sha256 = object.text("sha256");
  object.finish();
  return input;
}

TakeCheck read_check(JsonObject object) {
  TakeCheck check{object.count("samples"), object.count("disagreements"), object.number("worst_m"),
                  object.text("worst_at"), object.text("disagreed_at")};
  object.finish();
  return check;
}

TakeTracking read_tracking(JsonObject object) {
  TakeTracking tracking;
  for (JsonObject& row : object.objects("views")) tracking.views.push_back(read_view(row));
  for (JsonObject& row : object.objects("exchanges")) tracking.exchanges.push_back(read_exchange(row));
  for (JsonObject& row : object.objects("ranges")) {
    tracking.ranges.push_back({row.text("condition"), row.text("group"), row.count("n"), row.number("sum_m"),
                               row.number("squares_m2")});
    row.finish();
  }
  for (JsonObject& row : object.objects("predictions")) {
    tracking.predictions.push_back({row.text("participant"), row.text("condition"), row.text("method"),
                                    row.count("n"), row.number("range_m"), row.number("abs_range_m"),
                                    row.number("bearing_m")});
    row.finish();
  }
  JsonObject clock = object.object("clock");
  tracking.clock = read_clock(clock);
  JsonObject rays = object.object("rays");
  tracking.rays = read_ray(rays);
  object.finish();
  return tracking;
}

}  // namespace

void TakeCheck::merge(const TakeCheck& later) {
  samples += later.samples;
  disagreements += later.disagreements;
  if (disagreed_at.empty()) disagreed_at = later.disagreed_at;
  if (later.worst_m > worst_m) {
    worst_m = later.worst_m;
    worst_at = later.worst_at;
  }
}

Json json_of(const TakeResult& result) {
  Json json{{"evaluated", result.evaluated}, {"inputs", Json::array()}, {"notes", Json::array()}};
  for (const TakeInput& input : result.inputs) json["inputs"].push_back(json_of(input));
  for (const TakeNote& note : result.notes)
    json["notes"].push_back(
        {{"take", note.take}, {"failed", note.failed}, {"place", note.place}, {"text", note.text}});
  json["check"] = json_of(result.check);
  json["tracking"] = json_of(result.tracking);
  return json;
}

TakeResult read_take_result(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  TakeResult result;
  result.evaluated = object.boolean("evaluated", false);
  for (JsonObject& input : object.objects("inputs")) result.inputs.push_back(read_input(input));
  for (JsonObject& note : object.objects("notes")) {
    result.notes.push_back(
        {note.text("take"), note.boolean("failed", false), note.text("place"), note.text("text")});
    note.finish();
  }
  result.check = read_check(object.object("check"));
  result.tracking = read_tracking(object.object("tracking"));
  object.finish();
  return result;
}

RunOutcome outcome_of(const Plan& plan, std::span<const EvaluatedTake> takes, bool cross_check) {
  RunOutcome outcome;
  TakeCheck check;
  std::vector<TakeTracking> tracking;
  for (const EvaluatedTake& take : takes) {
    tracking.push_back(take.result.tracking);
    outcome.notes.insert(outcome.notes.end(), take.result.notes.begin(), take.result.notes.end());
    outcome.evaluated.push_back(take.result.evaluated);
    check.merge(take.result.check);
  }
  outcome.tracking = sum_tracking(plan, tracking);
  if (cross_check)
    outcome.cross_check = CrossCheck{checked_method(plan)->spec.name,
                                     check.samples,
                                     check.disagreements,
                                     check.worst_m,
                                     plan.study.cross_check_limit_m,
                                     check.disagreements > 0 ? check.disagreed_at : check.worst_at};
  return outcome;
}

}  // namespace trilat
