// SPDX-License-Identifier: MIT
#include "datasets/results/summary.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

Json json_of(const SummaryCell& cell) {
  return {{"method", cell.method},
          {"condition", cell.condition},
          {"group", cell.group},
          {"alignment", cell.alignment},
          {"asked", cell.asked},
          {"answered", cell.answered},
          {"coverage", cell.coverage()},
          {"statuses", counts_json(cell.statuses)},
          {"mae_m", cell.mae_m},
          {"axis_mae_m", cell.axis_mae_m},
          {"rmse_m", cell.rmse_m},
          {"median_m", cell.median_m},
          {"p90_m", cell.p90_m},
          {"p95_m", cell.p95_m},
          {"max_m", cell.max_m},
          {"mean_gdop", cell.mean_gdop},
          {"mean_iterations", cell.mean_iterations}};
}

SummaryCell read_cell(JsonObject& object) {
  SummaryCell cell;
  cell.method = object.text("method");
  cell.condition = object.text("condition");
  cell.group = object.text("group");
  cell.alignment = object.text("alignment");
  cell.asked = object.count("asked");
  cell.answered = object.count("answered");
  number_or_nan(object, "coverage");
  cell.statuses = read_counts(object.object("statuses"));
  cell.mae_m = number_or_nan(object, "mae_m");
  const Json& axes = object.value("axis_mae_m");
  if (!axes.is_array() || axes.size() != 3) object.refuse("axis_mae_m", "must be an array of 3");
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (axes[axis].is_number()) cell.axis_mae_m[axis] = axes[axis].get<double>();
  cell.rmse_m = number_or_nan(object, "rmse_m");
  cell.median_m = number_or_nan(object, "median_m");
  cell.p90_m = number_or_nan(object, "p90_m");
  cell.p95_m = number_or_nan(object, "p95_m");
  cell.max_m = number_or_nan(object, "max_m");
  cell.mean_gdop = number_or_nan(object, "mean_gdop");
  cell.mean_iterations = number_or_nan(object, "mean_iterations");
  object.finish();
  return cell;
}

Json json_of(const TakeNote& note) {
  return {{"take", note.take}, {"failed", note.failed}, {"place", note.place}, {"text", note.text}};
}

TakeNote read_note(JsonObject& object) {
  TakeNote note{object.text("take"), object.boolean("failed", false), object.text("place"),
                object.text("text")};
  object.finish();
  return note;
}

Json json_of(const CrossCheck& check) {
  return {{"method", check.method},   {"samples", check.samples}, {"disagreements", check.disagreements},
          {"worst_m", check.worst_m}, {"limit_m", check.limit_m}, {"worst_at", check.worst_at},
          {"passed", check.passed()}};
}

CrossCheck read_cross_check(JsonObject object) {
  CrossCheck check;
  check.method = object.text("method");
  check.samples = object.count("samples");
  check.disagreements = object.count("disagreements");
  check.worst_m = object.number("worst_m");
  check.limit_m = object.number("limit_m");
  check.worst_at = object.text("worst_at");
  object.boolean("passed", false);
  object.finish();
  return check;
}

}  // namespace

void write_summary(const std::filesystem::path& folder, const ResultsSummary& s) {
  Json json = results_head(ResultsKind::accuracy);
  json.update({{"study", s.study},
               {"campaign", s.campaign},
               {"simulated", s.simulated},
               {"takes", s.takes},
               {"takes_failed", s.takes_failed},
               {"participants", s.participants},
               {"methods", s.methods},
               {"conditions", s.conditions},
               {"groups", s.groups},
               {"alignments", s.alignments},
               {"cells", Json::array()},
               {"notes", Json::array()}});
  for (const SummaryCell& cell : s.cells) json["cells"].push_back(json_of(cell));
  for (const TakeNote& note : s.notes) json["notes"].push_back(json_of(note));
  if (s.cross_check) json["cross_check"] = json_of(*s.cross_check);
  write_file(folder / "summary.json", json_text(json, 1) + "\n");
}

ResultsSummary read_summary(const std::filesystem::path& folder) {
  const Json json = read_results_json(folder);
  JsonObject object(json, (folder / "summary.json").string(), "");
  check_results_head(object, ResultsKind::accuracy);
  ResultsSummary s;
  s.study = object.text("study");
  s.campaign = object.text("campaign");
  s.simulated = object.boolean("simulated", false);
  s.takes = object.count("takes");
  s.takes_failed = object.count("takes_failed");
  s.participants = object.count("participants");
  s.methods = object.texts("methods");
  s.conditions = object.texts("conditions");
  s.groups = object.texts("groups");
  s.alignments = object.texts("alignments");
  for (JsonObject& cell : object.objects("cells")) s.cells.push_back(read_cell(cell));
  for (JsonObject& note : object.objects("notes")) s.notes.push_back(read_note(note));
  if (object.has("cross_check")) s.cross_check = read_cross_check(object.object("cross_check"));
  object.finish();
  return s;
}

const SummaryCell* find_cell(const ResultsSummary& summary, const std::string& method,
                             const std::string& condition, const std::string& group,
                             const std::string& alignment) {
  for (const SummaryCell& cell : summary.cells)
    if (cell.method == method && cell.condition == condition && cell.group == group &&
        cell.alignment == alignment)
      return &cell;
  return nullptr;
}

}  // namespace trilat
