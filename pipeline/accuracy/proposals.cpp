// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/proposals.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/rig/calibration.h"
#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/take/truth_track.h"

namespace trilat {
namespace {

// Names of markers or bones that give a joint, all of which must exist, lower case and without signs; `@`
// stands for l and r. `bone` says whether an asset of this name must be a bone or a marker.
struct MarkerRule {
  Joint joint;  // the left one of two
  bool bone;
  std::vector<std::string> names;
};

// In the order of attempts: the first rule whose names all exist wins.
const std::vector<MarkerRule>& marker_rules() {
  constexpr bool kBone = true, kMarker = false;
  static const std::vector<MarkerRule> all{
      // Motive's skeleton, and its names for FBX; those of Mixamo, Unity, Xsens, Unreal and OpenSim
      {Joint::spine_base, kBone, {"hip"}},
      {Joint::spine_base, kBone, {"hips"}},
      {Joint::spine_base, kBone, {"pelvis"}},
      {Joint::spine_mid, kBone, {"chest"}},
      {Joint::spine_mid, kBone, {"spine1"}},
      {Joint::spine_shoulder, kBone, {"neck"}},
      {Joint::spine_shoulder, kBone, {"neck01"}},
      {Joint::neck, kBone, {"head"}},
      {Joint::shoulder_left, kBone, {"@uarm"}},
      {Joint::shoulder_left, kBone, {"@@arm"}},
      {Joint::shoulder_left, kBone, {"@@upperarm"}},
      {Joint::shoulder_left, kBone, {"upperarm@"}},
      {Joint::shoulder_left, kBone, {"humerus@"}},
      {Joint::elbow_left, kBone, {"@farm"}},
      {Joint::elbow_left, kBone, {"@@forearm"}},
      {Joint::elbow_left, kBone, {"@@lowerarm"}},
      {Joint::elbow_left, kBone, {"lowerarm@"}},
      {Joint::elbow_left, kBone, {"ulna@"}},
      {Joint::wrist_left, kBone, {"@hand"}},
      {Joint::wrist_left, kBone, {"@@hand"}},
      {Joint::wrist_left, kBone, {"hand@"}},
      {Joint::hip_left, kBone, {"@thigh"}},
      {Joint::hip_left, kBone, {"@@upleg"}},
      {Joint::hip_left, kBone, {"@@upperleg"}},
      {Joint::hip_left, kBone, {"@@thigh"}},
      {Joint::hip_left, kBone, {"thigh@"}},
      {Joint::hip_left, kBone, {"femur@"}},
      {Joint::knee_left, kBone, {"@shin"}},
      {Joint::knee_left, kBone, {"@@leg"}},
      {Joint::knee_left, kBone, {"@@lowerleg"}},
      {Joint::knee_left, kBone, {"@@shin"}},
      {Joint::knee_left, kBone, {"calf@"}},
      {Joint::knee_left, kBone, {"tibia@"}},
      {Joint::ankle_left, kBone, {"@foot"}},
      {Joint::ankle_left, kBone, {"@@foot"}},
      {Joint::ankle_left, kBone, {"foot@"}},
      {Joint::ankle_left, kBone, {"talus@"}},
      {Joint::foot_left, kBone, {"@toe"}},
      {Joint::foot_left, kBone, {"@@toebase"}},
      {Joint::foot_left, kBone, {"@@toe"}},
      {Joint::foot_left, kBone, {"@@toes"}},
      {Joint::foot_left, kBone, {"ball@"}},
      {Joint::foot_left, kBone, {"toes@"}},
      // joint centres
      {Joint::shoulder_left, kMarker, {"@sjc"}},
      {Joint::elbow_left, kMarker, {"@ejc"}},
      {Joint::wrist_left, kMarker, {"@wjc"}},
      {Joint::hip_left, kMarker, {"@hjc"}},
      {Joint::knee_left, kMarker, {"@kjc"}},
      {Joint::ankle_left, kMarker, {"@ajc"}},
      // Plug-in Gait and Conventional, with inner markers where there are any
      {Joint::head, kMarker, {"lfhd", "rfhd", "lbhd", "rbhd"}},
      {Joint::spine_shoulder, kMarker, {"c7", "clav"}},
      {Joint::spine_mid, kMarker, {"strn", "t10"}},
      {Joint::spine_base, kMarker, {"lasi", "rasi", "lpsi", "rpsi"}},
      {Joint::spine_base, kMarker, {"lasi", "rasi", "sacr"}},
      {Joint::shoulder_left, kMarker, {"@sho"}},
      {Joint::elbow_left, kMarker, {"@elb", "@elm"}},
      {Joint::elbow_left, kMarker, {"@elb"}},
      {Joint::wrist_left, kMarker, {"@wra", "@wrb"}},
      {Joint::knee_left, kMarker, {"@kne", "@knm"}},
      {Joint::knee_left, kMarker, {"@lfc", "@mfc"}},
      {Joint::knee_left, kMarker, {"@kne"}},
      {Joint::ankle_left, kMarker, {"@ank", "@med"}},
      {Joint::ankle_left, kMarker, {"@lmal", "@mmal"}},
      {Joint::ankle_left, kMarker, {"@ank"}},
      {Joint::foot_left, kMarker, {"@toe"}},
      // OpenPose's BODY_25, COCO and HALPE; the ears are to both sides of the head's middle
      {Joint::head, kMarker, {"lear", "rear"}},
      {Joint::head, kMarker, {"leftear", "rightear"}},
      {Joint::spine_base, kMarker, {"midhip"}},
      {Joint::spine_base, kMarker, {"pelvis"}},
      {Joint::spine_mid, kMarker, {"spinenavel"}},
      {Joint::spine_shoulder, kMarker, {"spinechest"}},
      {Joint::shoulder_left, kMarker, {"@shoulder"}},
      {Joint::shoulder_left, kMarker, {"@@shoulder"}},
      {Joint::elbow_left, kMarker, {"@elbow"}},
      {Joint::elbow_left, kMarker, {"@@elbow"}},
      {Joint::wrist_left, kMarker, {"@wrist"}},
      {Joint::wrist_left, kMarker, {"@@wrist"}},
      {Joint::hip_left, kMarker, {"@hip"}},
      {Joint::hip_left, kMarker, {"@@hip"}},
      {Joint::knee_left, kMarker, {"@knee"}},
      {Joint::knee_left, kMarker, {"@@knee"}},
      {Joint::ankle_left, kMarker, {"@ankle"}},
      {Joint::ankle_left, kMarker, {"@@ankle"}},
      {Joint::foot_left, kMarker, {"@bigtoe"}},
      {Joint::foot_left, kMarker, {"@@bigtoe"}},
      // OpenCap's
      {Joint::spine_base, kMarker, {"lasisstudy", "rasisstudy", "lpsisstudy", "rpsisstudy"}},
      {Joint::shoulder_left, kMarker, {"@shoulderstudy"}},
      {Joint::elbow_left, kMarker, {"@lelbowstudy", "@melbowstudy"}},
      {Joint::wrist_left, kMarker, {"@lwriststudy", "@mwriststudy"}},
      {Joint::knee_left, kMarker, {"@kneestudy", "@mkneestudy"}},
      {Joint::ankle_left, kMarker, {"@anklestudy", "@manklestudy"}},
      {Joint::foot_left, kMarker, {"@toestudy"}},
      // Baseline
      {Joint::spine_base, kMarker, {"waistlfront", "waistrfront", "waistlback", "waistrback"}},
      {Joint::shoulder_left, kMarker, {"@shouldertop"}},
      {Joint::elbow_left, kMarker, {"@elbowin", "@elbowout"}},
      {Joint::elbow_left, kMarker, {"@elbowout"}},
      {Joint::wrist_left, kMarker, {"@wristin", "@wristout"}},
      {Joint::knee_left, kMarker, {"@kneein", "@kneeout"}},
      {Joint::knee_left, kMarker, {"@kneeout"}},
      {Joint::ankle_left, kMarker, {"@anklein", "@ankleout"}},
      {Joint::ankle_left, kMarker, {"@ankleout"}}};
  return all;
}

// "@farm" -> "rfarm", "@@arm" -> "rightarm".
std::string of_side(std::string name, bool right) {
  if (name.starts_with("@@")) return (right ? "right" : "left") + name.substr(2);
  std::ranges::replace(name, '@', right ? 'r' : 'l');
  return name;
}

// Whether a name is this plain one, with a prefix ("Ann:wrist_left") or without.
bool is_called(const std::string& name, const std::string& plain) {
  constexpr const char* kSeparators = ":_. ";
  for (std::size_t begin = 0; begin < name.size();) {
    if (plain_name(name.substr(begin)) == plain) return true;
    begin = std::min(name.find_first_of(kSeparators, begin), name.size() - 1) + 1;
  }
  return false;
}

// The asset that is called so; several, of two persons, are none.
std::optional<std::size_t> asset_called(const MocapHeader& header, const std::string& name,
                                        const std::function<bool(AssetType)>& is_type) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < header.assets.size(); ++i) {
    const MocapAsset& asset = header.assets[i];
    if (!asset.has_position || !is_type(asset.type)) continue;
    if (!is_called(asset.name, name)) continue;
    if (found) return std::nullopt;
    found = i;
  }
  return found;
}

// Whether a file without bones calls its points as an animation's skeleton calls bones: it has an upper arm
// and a forearm, and no elbow. Its "LeftShoulder" is the collar bone.
bool has_names_of_bones(const MocapHeader& header) {
  const auto any = [&](const auto& is_such) {
    return std::ranges::any_of(header.assets, [&](const MocapAsset& asset) {
      return asset.type != AssetType::bone && asset.has_position && is_such(asset.name);
    });
  };
  const auto is_one_of = [](const std::vector<std::string>& plain) {
    return [plain](const std::string& name) {
      return std::ranges::any_of(plain, [&](const std::string& one) { return is_called(name, one); });
    };
  };
  return any(is_one_of({"leftarm", "leftupperarm", "upperarml", "humerusl"})) &&
         any(is_one_of({"leftforearm", "leftlowerarm", "lowerarml", "ulnal"})) &&
         !any([](const std::string& name) { return plain_name(name).find("elbow") != std::string::npos; });
}

bool is_bone(AssetType type) { return type == AssetType::bone; }
bool is_marker(AssetType type) {
  return type == AssetType::marker || type == AssetType::bone_marker || type == AssetType::rigid_body_marker;
}

// Key of the asset of this name. A marker may stand in an export twice, measured and solved: the measured one
// counts.
std::optional<std::string> key_called(const MocapHeader& header, const std::string& name, bool bone,
                                      bool all_are_bones) {
  std::optional<std::size_t> found;
  if (bone)
    found = asset_called(header, name, [&](AssetType type) { return all_are_bones || is_bone(type); });
  else if (found = asset_called(header, name, [](AssetType t) { return t == AssetType::marker; }); !found)
    found = asset_called(header, name, is_marker);
  return found ? std::optional(key_of(header, *found)) : std::nullopt;
}

// "head_1", "head_2" and so on, about a joint.
std::vector<std::string> markers_numbered(const MocapHeader& header, const std::string& name) {
  std::vector<std::string> keys;
  for (std::size_t i = 0; i < header.assets.size(); ++i) {
    const MocapAsset& asset = header.assets[i];
    const std::string text = plain_name(asset.name);
    const std::size_t end = text.find_last_not_of("0123456789") + 1;
    if (asset.type == AssetType::marker && asset.has_position && end < text.size() &&
        text.substr(0, end) == name)
      keys.push_back(key_of(header, i));
  }
  return keys;
}

std::vector<std::string> assets_of(const MocapHeader& header, Joint joint, bool all_are_bones) {
  if (!all_are_bones) {
    // rigid bodies that are called as a joint is, and whatever else
    if (const auto own =
            asset_called(header, plain_name(name_of(joint)), [](AssetType t) { return !is_bone(t); }))
      return {key_of(header, *own)};
    if (auto numbered = markers_numbered(header, plain_name(name_of(joint))); !numbered.empty())
      return numbered;
  }
  const bool right = name_of(joint).ends_with("_right");
  for (const MarkerRule& way : marker_rules()) {
    if (way.joint != (right ? mirror_of(joint) : joint) || (all_are_bones && !way.bone)) continue;
    std::vector<std::string> assets;
    for (const std::string& name : way.names)
      if (const auto key = key_called(header, of_side(name, right), way.bone, all_are_bones))
        assets.push_back(*key);
    if (assets.size() == way.names.size()) return assets;
  }
  return {};
}

}  // namespace

JointMapping propose_mapping(const MocapHeader& header) {
  JointMapping mapping;
  const bool all_are_bones = has_names_of_bones(header);
  for (int j = 0; j < kJointCount; ++j) {
    const auto joint = static_cast<Joint>(j);
    if (auto assets = assets_of(header, joint, all_are_bones); !assets.empty())
      mapping.joints.push_back({joint, std::move(assets)});
  }
  return mapping;
}

std::string bones_text(const MocapHeader& header) {
  if (!has_names_of_bones(header)) return {};
  for (const JointMapping::Entry& entry : propose_mapping(header).joints)
    if (entry.joint == Joint::shoulder_left) {
      const std::string& key = entry.assets.front();
      return fmt::format(
          "calls its points as bones; each is taken as the joint where it begins, {} as shoulder_left",
          key.substr(key.find(':') + 1));
    }
  return {};
}

bool is_in_mocap_world(const Take& take) { return read_calibration(take.calibration).world == "optitrack"; }

MocapStart find_mocap_start(const Take& take, double search_s, const RunControl& control) {
  Json joints = Json::array();
  for (const JointMapping::Entry& entry : read_mapping(take.mapping).joints)
    joints.push_back(std::string(name_of(entry.joint)));
  StudySpec study = parse_study({{"format", "trilat.study"},
                                 {"version", 1},
                                 {"kind", "accuracy"},
                                 {"name", "start"},
                                 {"joints", joints},
                                 {"alignments", {is_in_mocap_world(take) ? "none" : "rigid"}},
                                 {"clock", "motion"},
                                 {"methods", {{{"method", "mean"}}}}},
                                "start", {});
  study.clock_search_s = search_s;
  const Plan plan = make_plan(study, {.name = "start", .takes = {take}}, control);
  PlannedTake planned = plan.takes.front();
  if (!planned.ok) throw InputError(planned.place, planned.problem);
  planned.take.mocap_start_host_ns = planned.start.ns;
  const ClockOffsetRow clock = load_take(plan, planned, control.stop_requested).clock;
  if (!clock.applied) return {clock.status, cause_of(clock.status)};
  return {clock.status,  {},          planned.start.ns - duration_from_s(clock.offset_s).ns, -clock.offset_s,
          -clock.high_s, -clock.low_s};
}

}  // namespace trilat
