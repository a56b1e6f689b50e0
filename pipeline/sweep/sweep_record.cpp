// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_record.h"

#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/results/sweep_cell_json.h"

namespace trilat {

std::string line_of(const SweepRecord& record) {
  Json json{{"cell", record.cell},
            {"key", record.key},
            {"shard", record.shard.number},
            {"shards", record.shard.of},
            {"chunks", record.chunks}};
  if (record.reused)
    json.update({{"from", record.reused->from}, {"outcome", json_of(record.reused->cell)}});
  else
    json["totals"] = json_of(record.totals);
  const std::string text = json_text(json, -1);
  return hash_of_text(text) + ' ' + text;
}

std::optional<SweepRecord> read_sweep_record(const std::string& line, const std::string& place) {
  const std::size_t space = line.find(' ');
  if (space == std::string::npos) return std::nullopt;
  const std::string_view text = std::string_view(line).substr(space + 1);
  if (std::string_view(line).substr(0, space) != hash_of_text(text)) return std::nullopt;
  const Json json = parse_json(text, place);
  JsonObject object(json, place, "");
  SweepRecord record;
  record.cell = object.count("cell");
  record.key = object.text("key");
  record.shard = {object.count("shard"), object.count("shards")};
  record.chunks = object.count("chunks");
  if (object.has("outcome")) {
    JsonObject outcome = object.object("outcome");
    record.reused = {object.text("from"), read_sweep_cell(outcome)};
  } else {
    record.totals = read_sweep_totals(object.object("totals"));
  }
  object.finish();
  return record;
}

}  // namespace trilat
