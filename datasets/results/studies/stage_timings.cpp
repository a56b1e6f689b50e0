// SPDX-License-Identifier: MIT
#include "datasets/results/studies/stage_timings.h"

#include <cmath>
#include <numeric>

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {

namespace {

constexpr const char* kStagesFormat = "trilat.stage_timings";

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(); }

}  // namespace

void write_stage_timings(const std::filesystem::path& folder, const StageTimings& t) {
  Json json{{"format", kStagesFormat},
            {"version", 1},
            {"study", t.study},
            {"processor", t.processor},
            {"stages", Json::array()}};
  for (const StageTiming& s : t.stages)
    json["stages"].push_back({{"name", s.name}, {"method", s.method}, {"time", json_of(s.time)}});
  write_file(folder / "timings.json", json_text(json, 1) + "\n");
}

std::optional<StageTimings> read_stage_timings(const std::filesystem::path& folder) {
  const auto path = folder / "timings.json";
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Json json = read_json(path);
  JsonObject object(json, path.string(), "");
  check_format(object, kStagesFormat, 1);
  StageTimings t;
  t.study = object.text("study");
  t.processor = object.text("processor");
  for (JsonObject& entry : object.objects("stages")) {
    t.stages.push_back({entry.text("name"), entry.text("method"), read_time_spread(entry.object("time"))});
    entry.finish();
  }
  object.finish();
  return t;
}

Json json_of(const TimeSpread& s) {
  return {{"n", s.n},
          {"bins", s.bins},
          {"median_s", number_or_null(s.median_s)},
          {"p95_s", number_or_null(s.p95_s)},
          {"p99_s", number_or_null(s.p99_s)},
          {"p999_s", number_or_null(s.p999_s)},
          {"max_s", number_or_null(s.max_s)}};
}

TimeSpread read_time_spread(JsonObject object) {
  TimeSpread s;
  s.n = object.count("n");
  const Json& bins = object.value("bins");
  if (!bins.is_array() || bins.size() != s.bins.size())
    object.refuse("bins", "must hold one count for each of the table's ranges");
  for (std::size_t b = 0; b < s.bins.size(); ++b) {
    if (!bins[b].is_number_unsigned()) object.refuse("bins", "must hold counts");
    s.bins[b] = bins[b].get<std::uint64_t>();
  }
  if (std::accumulate(s.bins.begin(), s.bins.end(), std::uint64_t{0}) != s.n)
    object.refuse("bins", "must add up to n");
  s.median_s = number_or_nan(object, "median_s");
  s.p95_s = number_or_nan(object, "p95_s");
  s.p99_s = number_or_nan(object, "p99_s");
  s.p999_s = number_or_nan(object, "p999_s");
  s.max_s = number_or_nan(object, "max_s");
  object.finish();
  return s;
}

}  // namespace trilat
