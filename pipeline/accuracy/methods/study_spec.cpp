// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/study_spec.h"

#include <set>

#include "datasets/base/known_names.h"
#include "datasets/rig/skeleton.h"

namespace trilat {

void Stage::visit_settings(Stage& self, Fields& f) {
  f("poses", self.poses,
    opt("stated: of the takes' calibration; by the campaign's wand: wand, all places refined together; "
        "two_positions, printed: the paper's eq. 6 and 7, corrected and as printed"));
  f("sensor_clocks", self.sensor_clocks,
    opt("how a frame gets its time: offline, by its ticks and all exchanges of clocks; causal, by its "
        "arrival "
        "and the exchanges until then; printed, by eq. 20 to 22; exact, in simulations alone"));
  f("frames", self.frames,
    opt("what a sensor says at an instant: interpolated between the frames around it, or the newest that had "
        "arrived by then, held as long as sensor_gap_s"));
  if (f.when(self.frames == FrameChoice::newest))
    f("frame_late_s", self.frame_late_s,
      opt("a frame that arrives so long after its exposure is dropped", {0.0, 3600.0, true}));
  else
    f.useless({"frame_late_s"}, "without \"frames\": \"newest\"");
  f("repair_exchanges", self.repair_exchanges,
    opt("left and right that a sensor has exchanged are exchanged back"));
}

void Stage::fields(Stage& self, Fields& f) {
  f("name", self.name, need("of the condition"));
  visit_settings(self, f);
}

void Stages::read(const Json& json, const JsonPlace& place, const About& about) {
  json_value::check_list(json, place, about);
  std::set<std::string> names;
  for (std::size_t i = 0; i < json.size(); ++i) {
    push_back(empty() ? before : back());
    read_document(json[i], place.at(i), back());
    if (!names.insert(back().name).second)
      place.at(i).at("name").refuse("is \"" + back().name + "\", which an earlier stage has");
  }
}

Json Stages::json() const { return json_of(static_cast<const std::vector<Stage>&>(*this)); }

Json Stages::schema(const About& about) { return json_value::schema(std::vector<Stage>{}, about); }

void StudySpec::fields(StudySpec& self, Fields& f) {
  constexpr double kHour_s = 3600.0;
  std::size_t kind = 0;
  f.format("trilat.study");
  f.tag("kind", kind, {name_of(StudyKind::accuracy)}, "");
  f("name", self.name, need("of the study, printed in its tables"));
  if (f.writes_if(false))
    f("campaign", self.campaign, opt("folder of takes, relative to this file; `--campaign` goes first"));
  f("paper", self.paper, opt(kPaperStudyMeaning));
  f("sensors", self.sensors, opt("those that are used; empty: those of the take that has most"));
  About joints = opt("that are judged; empty: all that the mappings map");
  f("joints", self.joints, f.describes() ? std::move(joints).one_of(joint_names()) : joints);
  f("conditions", self.conditions, opt("activities whose takes are evaluated; empty: all"));
  f("occluded_apart", self.occluded_apart,
    opt("samples that a sensor sees occluded make conditions of their own"));
  f("truth", self.truth,
    opt("what estimates are held against: mocap, or what each sensor in turn sees, left out of every method; "
        "auto: mocap where any take has it"));
  f("reference", self.reference,
    opt("the method that the others are compared with; empty: the first; when it answers nothing, the first "
        "that does"));
  f("alignments", self.alignments,
    opt("how truth and estimates are brought together before they are compared").items(1));
  f("rate_hz", self.rate_hz, opt("of the instants that are evaluated", {0.0, 1000.0, true}));
  f("sensor_gap_s", self.sensor_gap_s,
    opt("no sensor is interpolated across a longer gap", {0.0, kHour_s, true}));
  f("truth_gap_s", self.truth_gap_s, opt("nor is the truth", {0.0, kHour_s, true}));
  Stage::visit_settings(self.stage, f);
  f("cross_check_limit_m", self.cross_check_limit_m, opt("`run --cross-check` fails beyond", kPositive));
  f("clock", self.clock,
    opt("whether the stated start of the truth is taken as it is, checked by motion, or corrected by it"));
  f("clock_search_s", self.clock_search_s,
    opt("how far to both sides of the stated start motion is compared", {0.02, 10.0}));
  f("training_share", self.training_share,
    opt("of a take, at its start: what the alignment joint_offset learns from", {0.05, 0.95}));
  f("clock_error_s", self.clock_error_s,
    opt("between truth and sensors, one standard deviation", {0.0, 1.0}));
  if (f.reads()) self.stages.before = self.stage;
  if (f.writes_if(!self.stages.empty()))
    f("stages", self.stages,
      opt("each a condition of its own: a name, and what changes beside the stage before (poses, "
          "sensor_clocks, frames, frame_late_s, repair_exchanges)")
          .items(1));
  f("methods", self.methods, opt("that are compared, beside those that takes bring").items(1));
}

void StudySpec::check(const JsonPlace& place) const {
  std::set<std::string> names;
  for (std::size_t i = 0; i < methods.size(); ++i)
    if (!names.insert(methods[i].name).second)
      place.at("methods").at(i).at("name").refuse("is \"" + methods[i].name +
                                                  "\", which an earlier method has; give each its own name");
  for (std::size_t j = 0; j < joints.size() && !methods.empty(); ++j)
    if (!joint_from_name(joints[j]))
      place.at("joints").at(j).refuse("is \"" + joints[j] + "\", which is not a joint; " +
                                      known_names(joints[j], joint_names()));
}

StudySpec parse_study(const Json& json, const std::string& place, const std::filesystem::path& folder) {
  return read_as<StudySpec>(json, {place, folder});
}

std::vector<Stage> stages_of(const StudySpec& study) {
  return study.stages.empty() ? std::vector{study.stage} : std::vector<Stage>(study.stages);
}

StudySpec at_stage(StudySpec study, const Stage& stage) {
  study.stage = stage;
  study.stages.clear();
  return study;
}

}  // namespace trilat
