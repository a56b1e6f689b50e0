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
const std::vector<std::string> kTruths{"auto", "mocap", "left_out_sensor"};
constexpr std::uint64_t kFewestResamples = 200;  // 2.5 % of fewer are not told from the ends

std::vector<AlignmentKind> read_alignments(JsonObject& object) {
  std::vector<AlignmentKind> result;
  for (const std::string& word : different_texts(object, "alignments")) {
    const auto kind = alignment_from_name(word);
    if (!kind) object.refuse("alignments", "has \"" + word + "\"; " + known_names(word, kAlignments));
    result.push_back(*kind);
  }
  object.words("alignments", kAlignments);
  if (result.empty()) object.refuse("alignments", "must name at least one alignment");
  return result;
}

void check_names(JsonObject& object, const StudySpec& spec) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < spec.methods.size(); ++i)
    if (!names.insert(spec.methods[i].name).second)
      object.objects("methods")[i].refuse(
          "name", "is \"" + spec.methods[i].name + "\", which an earlier method has; give each its own name");
  for (const std::string& joint : spec.joints)
    if (!joint_from_name(joint))
      object.refuse("joints",
                    "has \"" + joint + "\", which is no joint; " + known_names(joint, joint_names()));
}

}  // namespace

StudySpec read_accuracy_settings(JsonObject& object, const std::filesystem::path& folder) {
  StudySpec spec;
  object.format(kFormat);
  spec.name = object.text("name");
  if (const std::string campaign = object.text("campaign", ""); !campaign.empty())
    spec.campaign = folder / campaign;
  spec.sensors = different_texts(object, "sensors");
  spec.joints = different_texts(object, "joints");
  spec.conditions = different_texts(object, "conditions");
  setting(object, "occluded_apart", spec.occluded_apart,
          "samples that a sensor sees occluded make conditions of their own");
  spec.truth =
      static_cast<TruthSource>(object.choice("truth", kTruths, static_cast<std::size_t>(spec.truth)));
  spec.reference = object.text("reference", "");
  if (object.has("alignments")) spec.alignments = read_alignments(object);
  spec.rate_hz = object.positive("rate_hz", spec.rate_hz);
  if (spec.rate_hz > 1000.0) object.refuse("rate_hz", "must not be above 1000");
  spec.sensor_gap_s = object.positive("sensor_gap_s", spec.sensor_gap_s);
  spec.truth_gap_s = object.positive("truth_gap_s", spec.truth_gap_s);
  for (const char* gap : {"sensor_gap_s", "truth_gap_s"})
    if (object.number(gap, 0.0) > 3600.0) object.refuse(gap, "must not be longer than an hour");
  spec.cross_check_limit_m = object.positive("cross_check_limit_m", spec.cross_check_limit_m);
  spec.clock =
      static_cast<ClockSource>(object.choice("clock", kClocks, static_cast<std::size_t>(spec.clock)));
  setting(object, "clock_search_s", spec.clock_search_s, {0.02, 10.0},
          "how far to both sides of the stated start motion is compared");
  setting(object, "repair_exchanges", spec.repair_exchanges,
          "left and right that a sensor has exchanged are exchanged back");
  setting(object, "training_share", spec.training_share, {0.05, 0.95},
          "of a take, at its start: what the alignment joint_offset learns from");
  setting(object, "block_s", spec.block_s, {0.01, 3600.0},
          "length of the time blocks that intervals are drawn from");
  setting(object, "resamples", spec.resamples, {0, 10'000}, "of the intervals; 0: none, else at least 200");
  if (spec.resamples > 0 && spec.resamples < kFewestResamples)
    object.refuse("resamples", fmt::format("must be 0, for no intervals, or at least {}", kFewestResamples));
  setting(object, "clock_error_s", spec.clock_error_s, {0.0, 1.0},
          "between truth and sensors, one standard deviation");
  for (JsonObject& entry : object.objects("methods")) spec.methods.push_back(read_method(entry));
  if (spec.methods.empty()) object.refuse("methods", "must hold at least one method");
  object.words("joints", joint_names());
  object.about(
      {{"name", "of the study; stands in its tables"},
       {"campaign", "folder of takes, relative to this file; `--campaign` goes first"},
       {"sensors", "those that are used; empty: those of the take that has most"},
       {"joints", "that are judged; empty: all that the mappings map"},
       {"conditions", "activities whose takes are evaluated; empty: all"},
       {"truth",
        "what estimates are held against: mocap, or what each sensor in turn sees, left out of every method; "
        "auto: mocap where any take has it"},
       {"reference",
        "the method that the others are compared with; empty: the first; when it answers nothing, the first "
        "that does"},
       {"alignments", "how truth and estimates are brought together before they are compared"},
       {"rate_hz", "of the instants that are evaluated"},
       {"sensor_gap_s", "no sensor is interpolated across a longer gap"},
       {"truth_gap_s", "nor is the truth"},
       {"cross_check_limit_m", "`run --cross-check` fails beyond"},
       {"clock",
        "whether the stated start of the truth is taken as it is, checked by motion, or corrected by it"},
       {"methods", "that are compared"}});
  check_names(object, spec);
  return spec;
}

StudySpec parse_study(const Json& json, const std::string& place, const std::filesystem::path& folder) {
  JsonObject object(json, place, "");
  object.choice("kind", {"accuracy"});
  StudySpec spec = read_accuracy_settings(object, folder);
  object.finish();
  return spec;
}

Json resolved_json(const StudySpec& spec) {
  Json methods = Json::array();
  for (const MethodSpec& m : spec.methods) methods.push_back(resolved_json(m));
  Json alignments = Json::array();
  for (AlignmentKind kind : spec.alignments) alignments.push_back(std::string(name_of(kind)));
  return {{"format", kFormat},
          {"version", 1},
          {"kind", "accuracy"},
          {"name", spec.name},
          {"sensors", spec.sensors},
          {"joints", spec.joints},
          {"conditions", spec.conditions},
          {"occluded_apart", spec.occluded_apart},
          {"truth", kTruths.at(static_cast<std::size_t>(spec.truth))},
          {"reference", spec.reference},
          {"alignments", alignments},
          {"rate_hz", spec.rate_hz},
          {"sensor_gap_s", spec.sensor_gap_s},
          {"truth_gap_s", spec.truth_gap_s},
          {"cross_check_limit_m", spec.cross_check_limit_m},
          {"clock", kClocks[static_cast<std::size_t>(spec.clock)]},
          {"clock_search_s", spec.clock_search_s},
          {"repair_exchanges", spec.repair_exchanges},
          {"training_share", spec.training_share},
          {"block_s", spec.block_s},
          {"resamples", spec.resamples},
          {"clock_error_s", spec.clock_error_s},
          {"methods", methods}};
}

}  // namespace trilat
