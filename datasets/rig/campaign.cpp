// SPDX-License-Identifier: MIT
#include "datasets/rig/campaign.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <map>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/words.h"

namespace trilat {
namespace {

constexpr double kMinLength_m = 5e-5;  // from the lowest level to the highest; a unit may be wrong by 1000
constexpr double kMinCosine = 0.8;

using enum Joint;
// The joints of each level of a standing person, from the highest level. Arms may be anywhere: they have
// none.
const std::array<std::vector<Joint>, UpAxisEstimator::kLevels> kJointsOfLevel{
    {{head},
     {neck, spine_shoulder, shoulder_left, shoulder_right},
     {spine_base, hip_left, hip_right},
     {knee_left, knee_right},
     {ankle_left, ankle_right, foot_left, foot_right}}};

}  // namespace

void UpAxisEstimator::add(Joint joint, const Eigen::Vector3d& point_m) {
  if (!point_m.allFinite()) return;
  for (std::size_t level = 0; level < kLevels; ++level)
    if (std::ranges::find(kJointsOfLevel.at(level), joint) != kJointsOfLevel.at(level).end()) {
      levels_.at(level).sum_m += point_m;
      levels_.at(level).count += 1.0;
    }
}

std::optional<UpAxis> UpAxisEstimator::axis() const {
  const auto is_known = [](const Level& level) { return level.count > 0.0; };
  const auto highest = std::ranges::find_if(levels_, is_known);
  const auto lowest = std::find_if(levels_.rbegin(), levels_.rend(), is_known);
  if (highest == levels_.end()) return std::nullopt;
  const Eigen::Vector3d up_m = highest->sum_m / highest->count - lowest->sum_m / lowest->count;
  if (!(up_m.norm() > kMinLength_m)) return std::nullopt;
  if (up_m.y() > kMinCosine * up_m.norm()) return UpAxis::y;
  if (up_m.z() > kMinCosine * up_m.norm()) return UpAxis::z;
  return std::nullopt;
}

namespace {

// Reads the assets of one name: at least one, and none twice.
std::vector<std::string> read_assets(const Json& json, const JsonPlace& place) {
  std::vector<std::string> assets;
  json_value::read_value(json, place, need("assets").items(1), assets);
  return assets;
}

Json assets_schema() { return {{"type", "array"}, {"items", {{"type", "string"}}}, {"minItems", 1}}; }

// The mapping of a take without a session, whose points may have any name.
struct PointMapping {
  NamedPoints joints;
  static void fields(auto& self, auto&& f) {
    f.format("trilat.mapping");
    f("joints", self.joints,
      need("Joints, each with the assets whose mean it is; it is there only while all of them are"));
  }
};

}  // namespace

void NamedPoints::read(const Json& json, const JsonPlace& place, const About&) {
  json_value::check_object(json, place);
  for (const auto& [name, assets] : json.items()) push_back({name, read_assets(assets, place.at(name))});
}

Json NamedPoints::json() const {
  Json json = Json::object();
  for (const NamedPoint& point : *this) json[point.name] = point.assets;
  return json;
}

Json NamedPoints::schema(const About&) {
  return {{"type", "object"}, {"additionalProperties", assets_schema()}};
}

void JointMapping::Entries::read(const Json& json, const JsonPlace& place, const About&) {
  json_value::check_object(json, place);
  for (const auto& [name, assets] : json.items()) {
    const auto joint = joint_from_name(name);
    if (!joint) {
      const std::string nearest = nearest_name(name, joint_names());
      place.at(name).refuse("is not a joint; " + (nearest.empty() ? known_names(name, joint_names())
                                                                  : "did you mean \"" + nearest + "\"?"));
    }
    push_back({*joint, read_assets(assets, place.at(name))});
  }
  if (empty()) place.refuse("must map at least one joint");
}

Json JointMapping::Entries::json() const {
  Json json = Json::object();
  for (const Entry& entry : *this) json[std::string(name_of(entry.joint))] = entry.assets;
  return json;
}

Json JointMapping::Entries::schema(const About&) {
  Json schema{{"type", "object"}, {"properties", Json::object()}, {"required", Json::array()}};
  for (const std::string& name : joint_names()) schema["properties"][name] = assets_schema();
  schema["additionalProperties"] = false;
  return schema;
}

void Take::fields(Take& self, Fields& f) {
  const auto file = [&](const char* key, auto& path, const char* meaning) {
    if (f.writes_if(!path.empty())) f(key, path, opt(meaning));
  };
  f("id", self.id, need("Name of the take and of its files"));
  f("participant", self.participant, need("Person who is seen"));
  f("activity", self.activity, opt("Activity of the person, the condition in studies"));
  file("session", self.session, "Recording, relative to this file; a take may have joints instead");
  file("calibration", self.calibration, "Calibration of its sensors");
  file("mocap", self.mocap, "Truth; a take without one is judged by leaving out one sensor after the other");
  file("mapping", self.mapping, "Mapping of the truth's assets to joints");
  const bool has_mocap = !self.mocap.empty(), has_session = !self.session.empty();
  if (f.writes_if(has_mocap && has_session))
    f("mocap_start_host_ns", self.mocap_start_host_ns,
      opt("Reading of the recording's host clock at the first frame of the truth"));
  if (f.writes_if(has_mocap))
    visit_up_axis(f, self.up_axis, "Axis of the truth's world that points up; y where it is not stated");
  if (f.writes_if(!self.joints.empty()))
    f("joints", self.joints,
      opt("Joints of other methods or systems, beside the session or instead of it").items(1));
  if (!f.reads()) return;
  const auto needs = [&](const char* key, bool is_needed) {
    if (is_needed && !f.has(key, false)) f.refuse(key, "is missing");
  };
  const bool needs_session = self.joints.empty();
  needs("session", needs_session);
  needs("calibration", has_session || needs_session);
  if (!has_session) f.useless({"calibration", "mocap_start_host_ns"}, "without \"session\"");
  if (!has_session && !has_mocap) f.refuse("mocap", "is missing: against what are the joints held?");
  for (const char* key : {"mapping", "mocap_start_host_ns"}) needs(key, has_session && has_mocap);
  if (!has_mocap) f.useless({"mapping", "mocap_start_host_ns", "up_axis"}, "without \"mocap\"");
}

void Take::check(const JsonPlace& place) const {
  if (!is_plain_name(id))
    place.at("id").refuse("must be 1 to 100 letters, digits, '-', '_' or '.', not starting with '.'");
  if (participant.find_first_not_of(" \t") == std::string::npos)
    place.at("participant").refuse("must name the person; intervals are between participants");
  if (std::abs(mocap_start_host_ns / 2) > (std::int64_t{1} << 60))
    place.at("mocap_start_host_ns").refuse("is a time that no clock shows");
  std::set<std::string> methods;
  for (std::size_t i = 0; i < joints.size(); ++i)
    if (!methods.insert(joints[i].method).second)
      place.at("joints").at(i).at("method").refuse("is \"" + joints[i].method +
                                                   "\", which other joints of this take have");
}

void CampaignWand::fields(CampaignWand& self, Fields& f) {
  f("session", self.session, need("Recording in which the wand is held still at many places"));
  if (f.has("mocap", !self.mocap.empty())) {
    f("mocap", self.mocap, opt("OptiTrack's export of it; without one the poses have a world of their own"));
    f("asset", self.asset,
      f.describes() ? opt("Asset whose position is the ball's centre") : need("with mocap"));
    f("mocap_start_host_ns", self.mocap_start_host_ns,
      f.describes() ? opt("Reading of the recording's host clock at its first frame") : need("with mocap"));
  } else {
    f.useless({"asset", "mocap_start_host_ns"}, "without \"mocap\"");
  }
  f("ball_radius_m", self.ball_radius_m, opt("Radius of the wand's ball", kBallRadius_m));
}

void Campaign::check(const JsonPlace& place) const {
  std::set<std::string> ids;
  for (std::size_t t = 0; t < takes.size(); ++t)
    if (!ids.insert(takes[t].id).second)
      place.at("takes").at(t).at("id").refuse("is \"" + takes[t].id + "\", which an earlier take has");
}

JointMapping read_mapping(const std::filesystem::path& path) {
  return read_as<JointMapping>(read_json(path), path);
}

NamedPoints read_points(const std::filesystem::path& path) {
  NamedPoints points = read_as<PointMapping>(read_json(path), path).joints;
  if (points.empty()) JsonPlace(path).at("joints").refuse("must map at least one joint");
  return points;
}

std::string mapping_text(const JointMapping& mapping) { return utf8_json_text(json_of(mapping), 2); }

void write_mapping(const std::filesystem::path& path, const JointMapping& mapping) {
  write_file(path, mapping_text(mapping) + "\n");
}

Campaign read_campaign(const std::filesystem::path& path) {
  const std::filesystem::path file = std::filesystem::is_directory(path) ? path / "campaign.json" : path;
  if (!std::filesystem::exists(file) && std::filesystem::exists(path / "items"))
    throw InputError(
        path.string(),
        "is a campaign that is not finished; run the same `trilat simulate` again, it goes on from there");
  return parse_campaign(read_json(file), file);
}

Campaign parse_campaign(const Json& json, const std::filesystem::path& file) {
  auto campaign = read_as<Campaign>(json, file);
  campaign.folder = file.parent_path();
  return campaign;
}

void write_campaign(const std::filesystem::path& folder, Campaign campaign) {
  const auto make_relative = [&](std::filesystem::path& path) {
    if (!path.empty()) path = std::filesystem::relative(path, folder);
  };
  for (Take& take : campaign.takes) {
    for (std::filesystem::path* path : {&take.session, &take.calibration, &take.mocap, &take.mapping})
      make_relative(*path);
    for (ExternalJoints& joints : take.joints) make_relative(joints.file);
  }
  if (campaign.wand) make_relative(campaign.wand->session), make_relative(campaign.wand->mocap);
  for (StatedDistances& stated : campaign.stated_distances)
    make_relative(stated.session), make_relative(stated.places);
  for (FlatWall& wall : campaign.walls) make_relative(wall.session);
  write_file(folder / "campaign.json", utf8_json_text(json_of(campaign), 2) + "\n");
}

std::vector<std::string> suspicious_names(const Campaign& campaign) {
  const auto plain = [](const std::string& name) {
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    std::string letters;
    bool is_parted = false;
    for (const char c : name) {
      if (static_cast<unsigned char>(c) < 0x80 && !std::isalnum(static_cast<unsigned char>(c))) {
        is_parted = true;
        continue;
      }
      if (is_parted && !letters.empty() && is_digit(letters.back()) && is_digit(c)) letters += '-';
      is_parted = false;
      letters += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    return letters;
  };
  std::vector<std::string> odd;
  const auto look_at = [&](std::string Take::*name, const char* what, const char* twice) {
    std::map<std::string, std::set<std::string>> alike;
    for (const Take& take : campaign.takes) alike[plain(take.*name)].insert(take.*name);
    for (const auto& [letters, names] : alike)
      if (names.size() > 1)
        odd.push_back(fmt::format("has the {} \"{}\", which count as {} {}; if they are one, write one name",
                                  what, fmt::join(names, "\" and \""), names.size(), twice));
  };
  look_at(&Take::participant, "participants", "persons");
  look_at(&Take::activity, "activities", "conditions");
  return odd;
}

}  // namespace trilat
