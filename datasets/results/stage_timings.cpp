// SPDX-License-Identifier: MIT
#include "datasets/results/stage_timings.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

constexpr const char* kStagesFormat = "trilat.stage_timings";

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

}  // namespace trilat
