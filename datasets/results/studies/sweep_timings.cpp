// SPDX-License-Identifier: MIT
#include "datasets/results/studies/sweep_timings.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

constexpr const char* kTimingsFormat = "trilat.timings";

Json json_of(const SweepCellTiming& cell) {
  return {{"interpretation", cell.interpretation},
          {"threshold", cell.threshold},
          {"range", cell.range},
          {"scalar_median_ns", cell.scalar_median_ns},
          {"scalar_min_ns", cell.scalar_min_ns},
          {"batched_median_ns", cell.batched_median_ns},
          {"batched_min_ns", cell.batched_min_ns}};
}

SweepCellTiming read_cell_timing(JsonObject& object) {
  SweepCellTiming cell;
  cell.interpretation = object.count("interpretation");
  cell.threshold = object.count("threshold");
  cell.range = object.count("range");
  cell.scalar_median_ns = object.number("scalar_median_ns");
  cell.scalar_min_ns = object.number("scalar_min_ns");
  cell.batched_median_ns = object.number("batched_median_ns");
  cell.batched_min_ns = object.number("batched_min_ns");
  object.finish();
  return cell;
}

}  // namespace

void write_sweep_timings(const std::filesystem::path& folder, const SweepTimings& t) {
  Json json{{"format", kTimingsFormat}, {"version", 1},           {"study", t.study},
            {"processor", t.processor}, {"problems", t.problems}, {"repeats", t.repeats},
            {"cells", Json::array()}};
  for (const SweepCellTiming& cell : t.cells) json["cells"].push_back(json_of(cell));
  write_file(folder / "timings.json", json_text(json, 1) + "\n");
}

std::optional<SweepTimings> read_sweep_timings(const std::filesystem::path& folder) {
  const auto path = folder / "timings.json";
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Json json = read_json(path);
  JsonObject object(json, path.string(), "");
  check_format(object, kTimingsFormat, 1);
  SweepTimings t;
  t.study = object.text("study");
  t.processor = object.text("processor");
  t.problems = object.count("problems");
  t.repeats = object.count("repeats");
  for (JsonObject& cell : object.objects("cells")) t.cells.push_back(read_cell_timing(cell));
  object.finish();
  return t;
}

}  // namespace trilat
