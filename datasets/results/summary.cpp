// SPDX-License-Identifier: MIT
#include "datasets/results/summary.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"
#include "datasets/results/summary_cells.h"

namespace trilat {
namespace {

Json json_of(const TakeNote& note) {
  return {{"take", note.take}, {"failed", note.failed}, {"place", note.place}, {"text", note.text}};
}

TakeNote read_note(JsonObject& object) {
  TakeNote note{object.text("take"), object.boolean("failed", false), object.text("place"),
                object.text("text")};
  object.finish();
  return note;
}

Json json_of(const PairedErrors& paired) {
  return {{"n", paired.n}, {"mae_m", paired.mae_m}, {"reference_mae_m", paired.reference_mae_m}};
}

PairedErrors read_paired(JsonObject object) {
  PairedErrors paired;
  paired.n = object.count("n");
  paired.mae_m = number_or_nan(object, "mae_m");
  paired.reference_mae_m = number_or_nan(object, "reference_mae_m");
  object.finish();
  return paired;
}

Json json_of(const MethodFamily& family) {
  return {{"name", family.name}, {"sensors", family.sensors}, {"methods", family.methods}};
}

MethodFamily read_family(JsonObject& object) {
  MethodFamily family{object.text("name"), object.count("sensors"), object.texts("methods")};
  object.finish();
  return family;
}

Json json_of(const FamilyCell& cell) {
  return {{"family", cell.family},  {"condition", cell.condition}, {"mae_m", cell.mae_m},
          {"low_m", cell.low_m},    {"high_m", cell.high_m},       {"answered", cell.answered},
          {"best", cell.best},      {"best_m", cell.best_m},       {"worst", cell.worst},
          {"worst_m", cell.worst_m}};
}

FamilyCell read_family_cell(JsonObject& object) {
  FamilyCell cell;
  cell.family = object.text("family");
  cell.condition = object.text("condition");
  for (const auto& [key, value] : {std::pair{"mae_m", &cell.mae_m},
                                   {"low_m", &cell.low_m},
                                   {"high_m", &cell.high_m},
                                   {"answered", &cell.answered},
                                   {"best_m", &cell.best_m},
                                   {"worst_m", &cell.worst_m}})
    *value = number_or_nan(object, key);
  cell.best = object.text("best");
  cell.worst = object.text("worst");
  object.finish();
  return cell;
}

Json json_of(const SpeedErrors& e) {
  return {{"slow", e.slow}, {"slow_mae_m", e.slow_mae_m}, {"fast", e.fast}, {"fast_mae_m", e.fast_mae_m}};
}

SpeedErrors read_speed(JsonObject object) {
  const SpeedErrors e{object.count("slow"), object.count("fast"), number_or_nan(object, "slow_mae_m"),
                      number_or_nan(object, "fast_mae_m")};
  object.finish();
  return e;
}

Json json_of(const TakeJointRow& row) {
  return {{"take", row.take},
          {"participant", row.participant},
          {"condition", row.condition},
          {"group", row.group},
          {"joint", row.joint},
          {"method", row.method},
          {"asked", row.asked},
          {"answered", row.answered},
          {"mae_m", row.mae_m},
          {"both", json_of(row.both)},
          {"complete", json_of(row.complete)},
          {"by_speed", json_of(row.by_speed)}};
}

TakeJointRow read_take_joint(JsonObject& object) {
  TakeJointRow row;
  row.take = object.text("take");
  row.participant = object.text("participant");
  row.condition = object.text("condition");
  row.group = object.text("group");
  row.joint = object.text("joint");
  row.method = object.text("method");
  row.asked = object.count("asked");
  row.answered = object.count("answered");
  if (row.answered > row.asked) object.refuse("answered", "is more than was asked");
  row.mae_m = number_or_nan(object, "mae_m");
  row.both = read_paired(object.object("both"));
  row.complete = read_paired(object.object("complete"));
  row.by_speed = read_speed(object.object("by_speed"));
  if (row.by_speed.slow > row.answered || row.by_speed.fast > row.answered - row.by_speed.slow)
    object.refuse("by_speed", "has more samples than were answered");
  if (row.both.n > row.answered) object.refuse("both", "has more samples than were answered");
  if (row.complete.n > row.asked) object.refuse("complete", "has more samples than were asked");
  object.finish();
  return row;
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

constexpr const char* kMocap = "mocap";
constexpr const char* kLeftOut = "left_out_sensor";

}  // namespace

void write_summary(const std::filesystem::path& folder, const ResultsSummary& s) {
  Json json = results_head(StudyKind::accuracy);
  json.update({{"study", s.study},
               {"campaign", s.campaign},
               {"simulated", s.simulated},
               {"takes", s.takes},
               {"takes_failed", s.takes_failed},
               {"participants", s.participants},
               {"methods", s.methods},
               {"families", Json::array()},
               {"family_cells", Json::array()},
               {"reference", s.reference},
               {"conditions", s.conditions},
               {"groups", s.groups},
               {"alignments", s.alignments},
               {"resamples", s.resamples},
               {"block_s", s.block_s},
               {"cells", Json::array()},
               {"differences", Json::array()},
               {"bodies", Json::array()},
               {"truth_floor", Json::array()},
               {"by_take", Json::array()},
               {"notes", Json::array()},
               {"truth", s.left_out ? kLeftOut : kMocap}});
  for (const MethodFamily& family : s.families) json["families"].push_back(json_of(family));
  for (const FamilyCell& cell : s.family_cells) json["family_cells"].push_back(json_of(cell));
  for (const SummaryCell& cell : s.cells) json["cells"].push_back(json_of(cell));
  for (const DifferenceCell& cell : s.differences) json["differences"].push_back(json_of(cell));
  for (const BodyCell& cell : s.bodies) json["bodies"].push_back(json_of(cell));
  for (const TruthFloor& floor : s.truth_floor) json["truth_floor"].push_back(json_of(floor));
  for (const TakeJointRow& row : s.by_take) json["by_take"].push_back(json_of(row));
  for (const TakeNote& note : s.notes) json["notes"].push_back(json_of(note));
  if (s.cross_check) json["cross_check"] = json_of(*s.cross_check);
  write_file(folder / "summary.json", json_text(json, 1) + "\n");
}

ResultsSummary read_summary(const std::filesystem::path& folder) {
  const Json json = read_results_json(folder);
  JsonObject object(json, (folder / "summary.json").string(), "");
  check_results_head(object, StudyKind::accuracy);
  ResultsSummary s;
  s.study = object.text("study");
  s.campaign = object.text("campaign");
  s.simulated = object.boolean("simulated", false);
  s.takes = object.count("takes");
  s.takes_failed = object.count("takes_failed");
  s.participants = object.count("participants");
  s.left_out = object.text("truth", kMocap) == kLeftOut;  // earlier versions had mocap alone
  s.methods = object.texts("methods");
  for (JsonObject& family : object.objects("families")) s.families.push_back(read_family(family));
  for (JsonObject& cell : object.objects("family_cells")) s.family_cells.push_back(read_family_cell(cell));
  s.reference = object.text("reference");
  s.conditions = object.texts("conditions");
  s.groups = object.texts("groups");
  s.alignments = object.texts("alignments");
  if (s.alignments.empty()) object.refuse("alignments", "must name at least one alignment");
  s.resamples = object.count("resamples");
  s.block_s = number_or_nan(object, "block_s");
  for (JsonObject& cell : object.objects("cells")) s.cells.push_back(read_cell(cell));
  for (JsonObject& cell : object.objects("differences")) s.differences.push_back(read_difference(cell));
  for (JsonObject& cell : object.objects("bodies")) s.bodies.push_back(read_body(cell));
  for (JsonObject& floor : object.objects("truth_floor")) s.truth_floor.push_back(read_floor(floor));
  for (JsonObject& row : object.objects("by_take")) s.by_take.push_back(read_take_joint(row));
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
