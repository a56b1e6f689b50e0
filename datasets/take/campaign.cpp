// SPDX-License-Identifier: MIT
#include "datasets/take/campaign.h"

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
#include "datasets/base/known_names.h"
#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"
#include "datasets/base/units.h"

namespace trilat {
namespace {

constexpr double kMinLength_m = 5e-5;  // from the lowest level to the highest; a unit may be wrong by 1000
constexpr double kMinCosine = 0.8;

// What lies at one height of a person who stands, from the top. The arms may be anywhere.
using enum Joint;
const std::array<std::vector<Joint>, StandingAxis::kLevels> kJointsOfLevel{
    {{head},
     {neck, spine_shoulder, shoulder_left, shoulder_right},
     {spine_base, hip_left, hip_right},
     {knee_left, knee_right},
     {ankle_left, ankle_right, foot_left, foot_right}}};

}  // namespace

std::optional<UpAxis> read_up_axis(JsonObject& object) {
  object.words("up_axis", {kUpAxisNames.begin(), kUpAxisNames.end()});
  if (!object.has("up_axis")) return std::nullopt;
  if (object.value("up_axis") == "auto")
    object.refuse("up_axis", "\"auto\" was removed; leave the key out for y, or state \"z\"");
  return static_cast<UpAxis>(object.choice("up_axis", {kUpAxisNames.begin(), kUpAxisNames.end()}));
}

void StandingAxis::add(Joint joint, const Eigen::Vector3d& point_m) {
  if (!point_m.allFinite()) return;
  for (std::size_t level = 0; level < kLevels; ++level)
    if (std::ranges::find(kJointsOfLevel.at(level), joint) != kJointsOfLevel.at(level).end()) {
      levels_.at(level).sum_m += point_m;
      levels_.at(level).count += 1.0;
    }
}

std::optional<UpAxis> StandingAxis::axis() const {
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

constexpr const char* kCampaignFormat = "trilat.campaign";
constexpr const char* kMappingFormat = "trilat.mapping";

ExternalJoints read_joints(JsonObject& entry, const std::filesystem::path& folder) {
  ExternalJoints joints;
  joints.method = entry.text("method");
  joints.file = path_of(entry, "file", folder);
  if (entry.has("mapping")) {
    const Json& value = entry.value("mapping");
    if (!value.is_object()) entry.refuse("mapping", "must be an object: each joint with the file's names");
    JsonObject mapping = entry.below("mapping", value);
    joints.mapping = parse_points(mapping);
  }
  entry.shape(
      "mapping",
      R"({"type": "object", "additionalProperties": {"type": "array", "items": {"type": "string"}}})");
  joints.clock_by_motion = entry.choice("clock", {"stated", "motion"}, 0) == 1;
  entry.about({{"method", "name of its rows in the tables"},
               {"file", "TRC, OptiTrack CSV, or a CSV with time_s, joint, x_m, y_m, z_m"},
               {"mapping", "of joints to the file's names; without it they are known by their names"},
               {"clock", "stated: seconds since the recording's start; motion: found by the motion"}});
  entry.finish();
  return joints;
}

void read_external(JsonObject& entry, const std::filesystem::path& folder, Take& take) {
  if (!entry.has("joints")) return;
  for (JsonObject& one : entry.objects("joints")) {
    take.joints.push_back(read_joints(one, folder));
    const auto same = [&](const ExternalJoints& other) { return other.method == take.joints.back().method; };
    if (std::ranges::count_if(take.joints, same) > 1)
      one.refuse("method", "is \"" + take.joints.back().method + "\", which other joints of this take have");
  }
  if (take.joints.empty()) entry.refuse("joints", "must name at least one file");
}

Take read_take(JsonObject& entry, const std::filesystem::path& folder) {
  Take take;
  take.id = entry.text("id");
  if (!is_plain_name(take.id))
    entry.refuse("id", "must be 1 to 100 letters, digits, '-', '_' or '.', not starting with '.'");
  take.participant = entry.text("participant");
  take.activity = entry.text("activity", "");
  read_external(entry, folder, take);
  const bool has_session = take.joints.empty() || entry.has("session");
  if (has_session) {
    take.session = path_of(entry, "session", folder);
    take.calibration = path_of(entry, "calibration", folder);
  } else {
    for (const char* key : {"calibration", "mocap_start_host_ns"})
      if (entry.has(key)) entry.refuse(key, "is of no use without \"session\"");
    if (!entry.has("mocap")) entry.refuse("mocap", "is missing: against what are the joints held?");
  }
  if (entry.has("mocap")) {
    take.mocap = path_of(entry, "mocap", folder);
    if (has_session || entry.has("mapping")) take.mapping = path_of(entry, "mapping", folder);
    if (has_session) take.mocap_start_host_ns = entry.integer("mocap_start_host_ns");
    take.up_axis = read_up_axis(entry);
  }
  for (const char* key : {"mapping", "mocap_start_host_ns", "up_axis"})
    if (take.mocap.empty() && entry.has(key)) entry.refuse(key, "is of no use without \"mocap\"");
  if (std::abs(take.mocap_start_host_ns / 2) > (std::int64_t{1} << 60))
    entry.refuse("mocap_start_host_ns", "is a time that no clock shows");
  entry.about(
      {{"id", "of the take; names its files"},
       {"participant", "who is seen"},
       {"activity", "what the person does: the condition"},
       {"session", "recording, relative to this file; a take may have joints instead"},
       {"calibration", "of the sensors"},
       {"mocap", "the truth; a take without one is judged by leaving out one sensor after the other"},
       {"mapping", "of the truth's assets to joints"},
       {"mocap_start_host_ns", "what the recording's host clock showed at the first frame of the truth"},
       {"up_axis", "of the truth's world; y where it is not stated"},
       {"joints", "what other methods or systems gave, beside the session or instead of it"}});
  entry.finish();
  return take;
}

void read_ball_radius(JsonObject& object, double& ball_radius_m) {
  setting(object, "ball_radius_m", ball_radius_m, {0.01, 0.3}, "of the wand's ball");
}

CampaignWand read_wand(JsonObject object, const std::filesystem::path& folder) {
  CampaignWand wand{path_of(object, "session", folder)};
  if (object.has("mocap")) {
    wand.mocap = path_of(object, "mocap", folder);
    wand.asset = object.text("asset");
    wand.mocap_start_host_ns = object.integer("mocap_start_host_ns");
  }
  read_ball_radius(object, wand.ball_radius_m);
  object.about({{"session", "recording in which the wand is held still at many places"},
                {"mocap", "OptiTrack's export of it"},
                {"asset", "whose position is the ball's centre"},
                {"mocap_start_host_ns", "what the recording's host clock showed at its first frame"}});
  object.finish();
  return wand;
}

StatedDistances read_stated_distances(JsonObject object, const std::filesystem::path& folder) {
  StatedDistances stated{path_of(object, "session", folder), path_of(object, "places", folder)};
  read_ball_radius(object, stated.ball_radius_m);
  object.about({{"session", "recording in which the ball is held still at these places"},
                {"places", "CSV with from_s, to_s, sensor, distance_m, and angle_deg where it is known"}});
  object.finish();
  return stated;
}

FlatWall read_wall(JsonObject object, const std::filesystem::path& folder) {
  FlatWall wall{path_of(object, "session", folder)};
  constexpr double kMin_m = 0.3, kMax_m = 8.0;
  if (object.has("distance_m")) {
    wall.distance_m = object.number("distance_m");
    object.range("distance_m", kMin_m, kMax_m);
    if (!(*wall.distance_m >= kMin_m && *wall.distance_m <= kMax_m))
      object.refuse("distance_m",
                    fmt::format("is {:g}; state metres, {:g} to {:g}{}", *wall.distance_m, kMin_m, kMax_m,
                                in_metres_text(*wall.distance_m, kMin_m, kMax_m)));
  }
  object.about({{"session", "recording of a flat wall that fills the images"},
                {"distance_m", "from the sensors, where it was measured"}});
  object.finish();
  return wall;
}

}  // namespace

JointMapping read_mapping(const std::filesystem::path& path) {
  return parse_mapping(read_json(path), path.string());
}

JointMapping parse_mapping(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  object.format(kMappingFormat);
  JointMapping mapping;
  JsonObject joints = object.object("joints");
  for (const std::string& key : joints.keys()) {
    const auto joint = joint_from_name(key);
    if (!joint) {
      const std::string nearest = nearest_name(key, joint_names());
      joints.refuse(key, "is not a joint; " + (nearest.empty() ? known_names(key, joint_names())
                                                               : "did you mean \"" + nearest + "\"?"));
    }
    auto assets = joints.texts(key);
    if (assets.empty()) joints.refuse(key, "must name at least one asset");
    if (const std::string twice = first_repeated(assets); !twice.empty())
      joints.refuse(key, "names the asset \"" + twice + "\" twice");
    mapping.joints.push_back({*joint, std::move(assets)});
  }
  if (mapping.joints.empty()) object.refuse("joints", "must map at least one joint");
  object.about({{"joints", "each with the assets whose mean it is"}});
  object.finish();
  return mapping;
}

std::vector<NamedPoint> parse_points(JsonObject& json) {
  std::vector<NamedPoint> points;
  for (const std::string& key : json.keys()) {
    points.push_back({key, json.texts(key)});
    if (points.back().assets.empty()) json.refuse(key, "must name at least one asset");
    if (const std::string twice = first_repeated(points.back().assets); !twice.empty())
      json.refuse(key, "names the asset \"" + twice + "\" twice");
  }
  return points;
}

std::vector<NamedPoint> read_points(const std::filesystem::path& path) {
  const Json json = read_json(path);
  JsonObject object(json, path.string(), "");
  object.format(kMappingFormat);
  JsonObject joints = object.object("joints");
  std::vector<NamedPoint> points = parse_points(joints);
  if (points.empty()) object.refuse("joints", "must map at least one joint");
  object.finish();
  return points;
}

std::string mapping_text(const JointMapping& mapping) {
  Json joints = Json::object();
  for (const auto& entry : mapping.joints) joints[std::string(name_of(entry.joint))] = entry.assets;
  return exact_json_text(Json{{"format", kMappingFormat}, {"version", 1}, {"joints", joints}}, 2);
}

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
  JsonObject object(json, file.string(), "");
  object.format(kCampaignFormat);
  Campaign campaign;
  campaign.name = object.text("name");
  campaign.folder = file.parent_path();
  campaign.simulated = object.boolean("simulated", false);
  std::set<std::string> ids;
  for (JsonObject& entry : object.objects("takes")) {
    campaign.takes.push_back(read_take(entry, file.parent_path()));
    if (!ids.insert(campaign.takes.back().id).second)
      entry.refuse("id", "is \"" + campaign.takes.back().id + "\", which an earlier take has");
  }
  if (campaign.takes.empty()) object.refuse("takes", "must hold at least one take");
  if (object.has("wand")) campaign.wand = read_wand(object.object("wand"), file.parent_path());
  if (object.has("stated_distances"))
    for (JsonObject& entry : object.objects("stated_distances"))
      campaign.stated_distances.push_back(read_stated_distances(std::move(entry), file.parent_path()));
  if (object.has("walls"))
    for (JsonObject& entry : object.objects("walls"))
      campaign.walls.push_back(read_wall(std::move(entry), file.parent_path()));
  object.about({{"name", "of the campaign"},
                {"simulated", "every table says so"},
                {"takes", "what was recorded"},
                {"wand", "a recording to calibrate with"},
                {"stated_distances", "recordings of a ball at measured distances"},
                {"walls", "recordings of a flat wall"}});
  object.finish();
  return campaign;
}

void write_campaign(const std::filesystem::path& folder, const Campaign& campaign) {
  Json takes = Json::array();
  const auto inside = [&](const std::filesystem::path& path) {
    return std::filesystem::relative(path, folder).generic_string();
  };
  for (const Take& take : campaign.takes) {
    Json json{{"id", take.id}, {"participant", take.participant}, {"activity", take.activity}};
    const auto add_file = [&](const char* key, const std::filesystem::path& path) {
      if (!path.empty()) json[key] = inside(path);
    };
    add_file("session", take.session);
    add_file("calibration", take.calibration);
    add_file("mocap", take.mocap);
    add_file("mapping", take.mapping);
    if (!take.mocap.empty() && !take.session.empty()) json["mocap_start_host_ns"] = take.mocap_start_host_ns;
    if (!take.mocap.empty() && take.up_axis)
      json["up_axis"] = kUpAxisNames.at(static_cast<std::size_t>(*take.up_axis));
    for (const ExternalJoints& joints : take.joints) {
      json["joints"].push_back({{"method", joints.method}, {"file", inside(joints.file)}});
      for (const NamedPoint& point : joints.mapping)
        json["joints"].back()["mapping"][point.name] = point.assets;
      if (joints.clock_by_motion) json["joints"].back()["clock"] = "motion";
    }
    takes.push_back(json);
  }
  Json json{{"format", kCampaignFormat},
            {"version", 1},
            {"name", campaign.name},
            {"simulated", campaign.simulated},
            {"takes", takes}};
  if (const std::optional<CampaignWand>& wand = campaign.wand) {
    json["wand"] = {{"session", inside(wand->session)}, {"ball_radius_m", wand->ball_radius_m}};
    if (!wand->mocap.empty())
      json["wand"].update(Json{{"mocap", inside(wand->mocap)},
                               {"asset", wand->asset},
                               {"mocap_start_host_ns", wand->mocap_start_host_ns}});
  }
  for (const StatedDistances& stated : campaign.stated_distances)
    json["stated_distances"].push_back({{"session", inside(stated.session)},
                                        {"places", inside(stated.places)},
                                        {"ball_radius_m", stated.ball_radius_m}});
  for (const FlatWall& wall : campaign.walls) {
    json["walls"].push_back({{"session", inside(wall.session)}});
    if (wall.distance_m) json["walls"].back()["distance_m"] = *wall.distance_m;
  }
  write_file(folder / "campaign.json", exact_json_text(json, 2) + "\n");
}

std::vector<std::string> oddities_of(const Campaign& campaign) {
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
