// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/study_spec.h"

#include <set>

#include "datasets/base/words.h"
#include "datasets/rig/skeleton.h"

namespace trilat {

void Stage::visit_settings(Stage& self, Fields& f) {
  f("poses", self.poses,
    opt("Source of the sensors' poses. stated: the takes' calibration; wand: the campaign's wand, all places "
        "refined together; two_positions, printed: the wand's first two places by the paper's eq. 6 and 7, "
        "corrected and as printed"));
  f("sensor_clocks", self.sensor_clocks,
    opt("Source of a frame's time. offline: its ticks and all exchanges of clocks; causal: its arrival and "
        "the exchanges until then, as in a live system; printed: eq. 20 to 22; exact: the true clocks, in "
        "simulations alone"));
  f("frames", self.frames,
    opt("Frames that count at an instant. interpolated: those around it; newest: the newest that had arrived "
        "by then, held for sensor_gap_s at most"));
  if (f.when(self.frames == FrameChoice::newest))
    f("frame_late_s", self.frame_late_s,
      opt("Longest time from a frame's exposure to its arrival; later frames are dropped",
          {0.0, 3600.0, true}));
  else
    f.useless({"frame_late_s"}, "without \"frames\": \"newest\"");
  f("repair_exchanges", self.repair_exchanges,
    opt("Whether left and right that a sensor has exchanged are exchanged back"));
}

void Stage::fields(Stage& self, Fields& f) {
  f("name", self.name, need("Name of the condition"));
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
  f("name", self.name, need("Name of the study; its tables print it"));
  if (f.writes_if(false))
    f("campaign", self.campaign, opt("Folder of takes, relative to this file; `--campaign` goes first"));
  f("paper", self.paper, opt(kPaperStudyMeaning));
  f("sensors", self.sensors, opt("Sensors that are used; empty: those of the take that has most"));
  About joints = opt("Joints that are judged; empty: all that the mappings map");
  f("joints", self.joints, f.describes() ? std::move(joints).one_of(joint_names()) : joints);
  f("conditions", self.conditions, opt("Activities whose takes are evaluated; empty: all"));
  f("occluded_apart", self.occluded_apart,
    opt("Whether the samples that a sensor sees occluded make conditions of their own"));
  f("truth", self.truth,
    opt("Positions that estimates are compared with. mocap; left_out_sensor: what each sensor in turn sees, "
        "left out of every method; auto: mocap where any take has it"));
  f("reference", self.reference,
    opt("Method that the others are compared with; empty: the first; when it answers nothing, the first that "
        "does"));
  f("alignments", self.alignments,
    opt("Ways to bring truth and estimates together before they are compared. none: as they are; first, "
        "mean: each joint moved so that its first pair, or its mean, lies on the truth's; rigid: one "
        "rotation and translation for all joints of a method in a take, the only one for a calibration that "
        "is not in OptiTrack's world; joint_offset: less each joint's mean error, in the body's own frame, "
        "of the first part of the take; held_out: as none, over the rest of the take, as joint_offset")
        .items(1));
  f("rate_hz", self.rate_hz, opt("Instants a second that are evaluated", {0.0, 1000.0, true}));
  f("sensor_gap_s", self.sensor_gap_s,
    opt("Longest gap across which a sensor is interpolated", {0.0, kHour_s, true}));
  f("truth_gap_s", self.truth_gap_s,
    opt("Longest gap across which the truth is interpolated", {0.0, kHour_s, true}));
  Stage::visit_settings(self.stage, f);
  f("cross_check_limit_m", self.cross_check_limit_m,
    opt("Difference beyond which `run --cross-check` fails", kPositive));
  f("clock", self.clock,
    opt("Use of the stated start of the truth. stated: taken as it is; check: the same, and the offset that "
        "the motion shows is reported; motion: that offset is applied, with the trackers' lag in it, which "
        "motion cannot tell from a clock"));
  f("clock_search_s", self.clock_search_s,
    opt("Time to both sides of the stated start over which motion is compared", {0.02, 10.0}));
  f("training_share", self.training_share,
    opt("Share of a take, at its start, that the alignment joint_offset learns from", {0.05, 0.95}));
  f("clock_error_s", self.clock_error_s,
    opt("Standard deviation of the clock between truth and sensors", {0.0, 1.0}));
  if (f.reads()) self.stages.before = self.stage;
  if (f.writes_if(!self.stages.empty()))
    f("stages", self.stages,
      opt("Stages from recording to methods, each a condition of its own: a name, and what changes beside "
          "the stage before (poses, sensor_clocks, frames, frame_late_s, repair_exchanges)")
          .items(1));
  f("methods", self.methods, opt("Methods that are compared, beside those that takes bring").items(1));
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
