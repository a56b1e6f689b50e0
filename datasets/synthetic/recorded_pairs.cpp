// SPDX-License-Identifier: MIT
#include "datasets/synthetic/recorded_pairs.h"

#include "datasets/base/strict_json.h"
#include "datasets/synthetic/embedded_tracker.h"

namespace trilat {
namespace {

RecordedPairs read() {
  constexpr const char* kPlace = "datasets/synthetic/recorded_pairs.json";
  const Json json = parse_json(embedded::recorded_pairs_json, kPlace);
  JsonObject object(json, kPlace, "");
  object.format("trilat.recorded_pairs");
  RecordedPairs recorded;
  recorded.source = object.text("source");
  recorded.distance_m = object.positive("distance_m");
  recorded.height_m = object.positive("height_m");
  for (JsonObject& entry : object.objects("pairs")) {
    recorded.pairs.push_back({entry.text("name"), entry.number("degrees")});
    entry.finish();
  }
  for (JsonObject& entry : object.objects("activities")) {
    recorded.activities.push_back({entry.text("name"),
                                   static_cast<Activity>(entry.choice("simulated", activity_names())),
                                   entry.positive("duration_s")});
    entry.finish();
  }
  for (JsonObject& entry : object.objects("sets")) {
    recorded.sets.push_back(
        {entry.text("name"), entry.count("participants"), read_list<PairQuantiles>(entry, "rows")});
    entry.finish();
  }
  object.finish();
  return recorded;
}

}  // namespace

const RecordedPairs& recorded_pairs() {
  static const RecordedPairs recorded = read();
  return recorded;
}

}  // namespace trilat
