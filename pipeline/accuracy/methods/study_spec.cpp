// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/study_spec.h"

#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/known_names.h"
#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"
#include "datasets/skeleton/skeleton.h"

namespace trilat {
namespace {

constexpr const char* kFormat = "trilat.study";
const std::vector<std::string> kAlignments{"none", "first", "mean", "rigid", "held_out", "joint_offset"};
const std::vector<std::string> kClocks{"stated", "check", "motion"};
const std::vector<std::string> kFrames{"interpolated", "newest"};
const std::vector<std::string> kPoses{"stated", "wand", "two_positions", "printed"};
const std::vector<std::string> kSensorClocks{"offline", "exact", "causal", "printed"};
const std::vector<std::string> kTruths{"auto", "mocap", "left_out_sensor"};

void tell_alignments(Settings& s, std::vector<AlignmentKind>& kinds) {
  JsonObject* object = s.reading();
  if (object && object->has("alignments")) {
    kinds.clear();
    for (const std::string& word : different_texts(*object, "alignments")) {
      const auto kind = alignment_from_name(word);
      if (!kind) object->refuse("alignments", "has \"" + word + "\"; " + known_names(word, kAlignments));
      kinds.push_back(*kind);
    }
    object->words("alignments", kAlignments);
    if (kinds.empty()) object->refuse("alignments", "must name at least one alignment");
    object->about({{"alignments", "how truth and estimates are brought together before they are compared"}});
  }
  Json names = Json::array();
  for (AlignmentKind kind : kinds) names.push_back(std::string(name_of(kind)));
  s.write("alignments", names);
}

void tell(Settings& s, Stage& stage) {
  s.choice("poses", stage.poses, kPoses,
           "stated: of the takes' calibration; by the campaign's wand: wand, all places refined together; "
           "two_positions, printed: the paper's eq. 6 and 7, corrected and as printed");
  s.choice("sensor_clocks", stage.sensor_clocks, kSensorClocks,
           "how a frame gets its time: offline, by its ticks and all exchanges of clocks; causal, by its "
           "arrival and the exchanges until then; printed, by eq. 20 to 22; exact, in simulations alone");
  s.choice(
      "frames", stage.frames, kFrames,
      "what a sensor says at an instant: interpolated between the frames around it, or the newest that had "
      "arrived by then, held as long as sensor_gap_s");
  if (stage.frames == FrameChoice::newest)
    s.positive("frame_late_s", stage.frame_late_s,
               "a frame that arrives so long after its exposure is dropped");
  s("repair_exchanges", stage.repair_exchanges,
    "left and right that a sensor has exchanged are exchanged back");
}

void read_stages(JsonObject& object, StudySpec& spec) {
  if (!object.has("stages")) return;
  Stage stage = spec.stage;
  std::set<std::string> names;
  for (JsonObject& entry : object.objects("stages")) {
    stage.name = entry.text("name");
    entry.about({{"name", "of the condition"}});
    if (!names.insert(stage.name).second)
      entry.refuse("name", "is \"" + stage.name + "\", which an earlier stage has");
    Settings settings(entry);
    tell(settings, stage);
    entry.finish();
    spec.stages.push_back(stage);
  }
  object.about({{"stages",
                 "each a condition of its own: a name, and what changes beside the stage before (poses, "
                 "sensor_clocks, frames, frame_late_s, repair_exchanges)"}});
  if (spec.stages.empty()) object.refuse("stages", "must hold at least one stage");
}

void check_names(JsonObject& object, const StudySpec& spec) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < spec.methods.size(); ++i)
    if (!names.insert(spec.methods[i].name).second)
      object.objects("methods")[i].refuse(
          "name", "is \"" + spec.methods[i].name + "\", which an earlier method has; give each its own name");
  for (const std::string& joint : spec.joints)
    if (!spec.methods.empty() && !joint_from_name(joint))
      object.refuse("joints",
                    "has \"" + joint + "\", which is not a joint; " + known_names(joint, joint_names()));
}

void tell(Settings& s, StudySpec& spec) {
  JsonObject* object = s.reading();
  s.choice("paper", spec.paper, kPaperStudies, kPaperStudyMeaning);
  s.texts("sensors", spec.sensors, "those that are used; empty: those of the take that has most");
  s.texts("joints", spec.joints, "that are judged; empty: all that the mappings map");
  s.texts("conditions", spec.conditions, "activities whose takes are evaluated; empty: all");
  s("occluded_apart", spec.occluded_apart,
    "samples that a sensor sees occluded make conditions of their own");
  s.choice("truth", spec.truth, kTruths,
           "what estimates are held against: mocap, or what each sensor in turn sees, left out of every "
           "method; auto: mocap where any take has it");
  s("reference", spec.reference,
    "the method that the others are compared with; empty: the first; when it answers nothing, the first that "
    "does");
  tell_alignments(s, spec.alignments);
  s.positive("rate_hz", spec.rate_hz, "of the instants that are evaluated");
  s.positive("sensor_gap_s", spec.sensor_gap_s, "no sensor is interpolated across a longer gap");
  s.positive("truth_gap_s", spec.truth_gap_s, "nor is the truth");
  tell(s, spec.stage);
  s.positive("cross_check_limit_m", spec.cross_check_limit_m, "`run --cross-check` fails beyond");
  s.choice("clock", spec.clock, kClocks,
           "whether the stated start of the truth is taken as it is, checked by motion, or corrected by it");
  s("clock_search_s", spec.clock_search_s, {0.02, 10.0},
    "how far to both sides of the stated start motion is compared");
  s("training_share", spec.training_share, {0.05, 0.95},
    "of a take, at its start: what the alignment joint_offset learns from");
  s("clock_error_s", spec.clock_error_s, {0.0, 1.0}, "between truth and sensors, one standard deviation");
  if (!object) return;
  if (spec.rate_hz > 1000.0) object->refuse("rate_hz", "must not be above 1000");
  for (const char* gap : {"sensor_gap_s", "truth_gap_s"})
    if (object->number(gap, 0.0) > 3600.0) object->refuse(gap, "must not be longer than an hour");
}

}  // namespace

StudySpec parse_study(const Json& json, const std::string& place, const std::filesystem::path& folder) {
  JsonObject object(json, place, "");
  object.choice("kind", {"accuracy"});
  StudySpec spec;
  object.format(kFormat);
  spec.name = object.text("name");
  if (const std::string campaign = object.text("campaign", ""); !campaign.empty())
    spec.campaign = folder / campaign;
  object.about({{"name", "of the study, printed in its tables"},
                {"campaign", "folder of takes, relative to this file; `--campaign` goes first"}});
  Settings settings(object);
  tell(settings, spec);
  read_stages(object, spec);
  object.words("joints", joint_names());
  if (object.has("methods")) {
    for (JsonObject& entry : object.objects("methods")) spec.methods.push_back(read_method(entry));
    if (spec.methods.empty()) object.refuse("methods", "must hold at least one method");
  }
  object.about({{"methods", "that are compared, beside those that takes bring"}});
  check_names(object, spec);
  object.finish();
  return spec;
}

std::vector<Stage> stages_of(const StudySpec& study) {
  return study.stages.empty() ? std::vector{study.stage} : study.stages;
}

StudySpec at_stage(StudySpec study, const Stage& stage) {
  study.stage = stage;
  study.stages.clear();
  return study;
}

Json resolved_json(StudySpec spec) {
  Json json{{"format", kFormat}, {"version", 1}, {"kind", "accuracy"}, {"name", spec.name}};
  Settings settings(json);
  tell(settings, spec);
  for (Stage& stage : spec.stages) {
    Json& written = json["stages"].emplace_back(Json{{"name", stage.name}});
    Settings own(written);
    tell(own, stage);
  }
  json["methods"] = Json::array();
  for (const MethodSpec& m : spec.methods) json["methods"].push_back(resolved_json(m));
  return json;
}

}  // namespace trilat
