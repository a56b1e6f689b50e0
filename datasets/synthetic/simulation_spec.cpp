// SPDX-License-Identifier: MIT
#include "datasets/synthetic/simulation_spec.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/known_names.h"
#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"
#include "datasets/base/units.h"
#include "datasets/synthetic/generated_person.h"

namespace trilat {
namespace {

constexpr const char* kPaper = "Yang, Dong, El Saddik, arXiv 2212.14771";
constexpr const char* kAssumption = "assumption: no published figure";
constexpr const char* kCalibrations = "public calibrations of Kinect v2 units";
constexpr const char* kSensor = "Kinect for Windows SDK 2.0 documentation";

std::string text(double value) { return fmt::format("{:g}", value); }
std::string between(double half) { return fmt::format("+-{:g}", half); }

void add_persons(const SimulationSpec& s, std::vector<DeclaredParameter>& list) {
  list.push_back({"participants", std::to_string(s.participants), "", kPaper});
  if (s.recorded) {
    list.push_back({"motion", "recorded take", "", s.recorded->mocap.filename().string()});
  } else {
    list.push_back({"stature", text(s.stature_mean_m) + between(s.stature_half_range_m), "m", kPaper});
    list.push_back(
        {"segments", "fractions of the stature", "", "Drillis and Contini 1966, as tabulated by Winter"});
  }
}

void add_rig(const RigSpec& rig, std::vector<DeclaredParameter>& list) {
  std::string heights;
  for (double height_m : rig.heights_m) heights += (heights.empty() ? "" : ", ") + text(height_m);
  list.push_back({"rig radius", text(rig.radius_m), "m", kPaper});
  list.push_back({"sensor heights", heights, "m", "assumption: the paper does not say"});
  list.push_back({"arc of the rig", text(rig.arc_rad / kRadPerDegree), "degrees", kAssumption});
  list.push_back({"start of the arc", text(rig.arc_start_rad / kRadPerDegree), "degrees", kAssumption});
  list.push_back(
      {"error of the calibration",
       text(rig.position_sigma_m) + " m, " + text(rig.rotation_sigma_rad / kRadPerDegree) + " degrees",
       "sigma an axis", kAssumption});
}

void add_sensor(const SensorSpec& s, std::vector<DeclaredParameter>& list) {
  list.push_back({"frame rate", text(s.rate_hz), "Hz", kSensor});
  list.push_back({"range", text(s.nearest_m) + " to " + text(s.farthest_m), "m", kSensor});
  list.push_back({"focal length between units", between(s.focal_spread_px), "px", kCalibrations});
  list.push_back({"image centre between units", between(s.centre_spread_px), "px", kCalibrations});
  list.push_back({"frames lost", text(s.dropped_share), "of frames", kAssumption});
  list.push_back({"clock drift", between(s.free_running ? s.clock_drift_ppm : 0.0), "ppm",
                  "tolerance of common crystal oscillators"});
  list.push_back(
      {"latency", text(s.latency_s), "s", "at least 20 ms by the sensor's makers; stated in the session"});
  list.push_back({"arrival jitter", text(s.arrival_jitter_s), "s, mean of exponential", kAssumption});
  list.push_back({"clock exchanges", "every " + text(s.exchange_period_s), "s", kAssumption});
  list.push_back({"exchange jitter", text(s.exchange_jitter_s), "s, mean of exponential", kAssumption});
}

void add_mocap(const MocapSpec& m, std::vector<DeclaredParameter>& list) {
  list.push_back({"mocap rate", text(m.rate_hz), "Hz", "OptiTrack V100:R2 of the paper"});
  list.push_back({"marker noise", text(m.marker_noise_sigma_m), "m, sigma an axis", kAssumption});
  list.push_back({"marker gaps", text(m.gap_share), "of 0.2 s stretches", kAssumption});
  list.push_back({"error of the stated start", between(m.clock_error_s), "s", kPaper});
}

}  // namespace

std::vector<DeclaredParameter> simulation_parameters(const SimulationSpec& spec) {
  std::vector<DeclaredParameter> list;
  add_persons(spec, list);
  add_rig(spec.rig, list);
  add_sensor(spec.sensor, list);
  for (DeclaredParameter& parameter : tracker_parameters(spec.body_tracker))
    list.push_back(std::move(parameter));
  if (!spec.recorded) add_mocap(spec.mocap, list);
  return list;
}

namespace {

constexpr const char* kFormat = "trilat.simulation";

// The permutation of 0 to n - 1 at `share` of all of them, in their lexical order.
std::vector<std::size_t> permutation_at(double share, std::size_t n) {
  std::vector<std::size_t> left(n), order;
  std::iota(left.begin(), left.end(), std::size_t{0});
  while (!left.empty()) {
    share *= static_cast<double>(left.size());
    const std::size_t k = std::min(static_cast<std::size_t>(share), left.size() - 1);
    order.push_back(left[k]);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
    share -= static_cast<double>(k);
  }
  return order;
}

// Heights at equal steps, in one of their orders around the circle.
std::vector<double> read_height_range(JsonObject object) {
  std::uint64_t sensors = 4;
  double mean_m = 1.4, spread_m = 1.6, order = 0.0;
  setting(object, "sensors", sensors, {1, 8}, "how many");
  setting(object, "mean_m", mean_m, {0.1, 5.0}, "height");
  setting(object, "spread_m", spread_m, {0.0, 5.0}, "between the lowest and the highest");
  setting(object, "order", order, {0.0, 1.0},
          "share of all orders around the circle, from rising to falling heights");
  object.finish();
  std::vector<double> heights_m;
  for (const std::size_t k : permutation_at(order, sensors)) {
    const double step = sensors == 1 ? 0.5 : static_cast<double>(k) / static_cast<double>(sensors - 1);
    heights_m.push_back(mean_m + (step - 0.5) * spread_m);
  }
  return heights_m;
}

RigSpec read_rig(JsonObject object) {
  RigSpec rig;
  setting(object, "radius_m", rig.radius_m, {0.3, 20.0}, "of the circle on which the sensors stand");
  if (object.has("heights_m")) {
    if (object.value("heights_m").is_object()) {
      rig.heights_m = read_height_range(object.object("heights_m"));
    } else {
      const std::size_t sensors = object.value("heights_m").size();
      if (sensors < 1 || sensors > 8) object.refuse("heights_m", "must hold 1 to 8 heights, one a sensor");
      rig.heights_m = object.numbers("heights_m", sensors);
      constexpr double kMaxHeight_m = 8.0;
      for (const double height_m : rig.heights_m)
        if (!(height_m >= 0.0 && height_m <= kMaxHeight_m))
          object.refuse("heights_m", fmt::format("has {:g}; heights are 0 to {:g} m above the floor",
                                                 height_m, kMaxHeight_m));
    }
  }
  setting(object, "arc_deg", rig.arc_rad, {1.0, 360.0},
          "of the circle, in equal parts: a sensor stands in the middle of each", kRadPerDegree);
  setting(object, "arc_start_deg", rig.arc_start_rad, {-360.0, 360.0},
          "where the arc begins, from +z towards +x; a person who stands faces +z", kRadPerDegree);
  setting(object, "position_sigma_m", rig.position_sigma_m, {0.0, 1.0},
          "error of the calibration that is written, an axis");
  setting(object, "rotation_sigma_deg", rig.rotation_sigma_rad, {0.0, 45.0}, "and of its rotations",
          kRadPerDegree);
  if (object.has("centre_m")) {
    const auto c = object.numbers("centre_m", 3);
    rig.centre_m = Eigen::Vector3d(c[0], c[1], c[2]);
  }
  object.about({{"heights_m", "one a sensor, or an object of sensors, mean_m, spread_m and order"},
                {"centre_m", "where they look; without it (0, 1, 0), or the middle of a recorded take"}});
  object.finish();
  return rig;
}

SensorSpec read_sensor(JsonObject object) {
  SensorSpec s;
  setting(object, "rate_hz", s.rate_hz, {1.0, 1000.0}, "of frames");
  setting(object, "nearest_m", s.nearest_m, {0.0, kUnlimited}, "at which a joint is seen");
  s.farthest_m = object.positive("farthest_m", s.farthest_m);
  if (s.farthest_m <= s.nearest_m) object.refuse("farthest_m", "must be farther than nearest_m");
  setting(object, "dropped_share", s.dropped_share, {0.0, 1.0}, "of frames");
  setting(object, "clock_drift_ppm", s.clock_drift_ppm, {0.0, 500.0}, "uniform in +-, of sensor and machine");
  setting(object, "latency_s", s.latency_s, {0.0, 1.0}, "exposure to arrival, the constant part");
  setting(object, "arrival_jitter_s", s.arrival_jitter_s, {0.0, 1.0}, "mean of the exponential part");
  setting(object, "exchange_period_s", s.exchange_period_s, {0.01, 3600.0},
          "between two exchanges of clock messages");
  setting(object, "exchange_jitter_s", s.exchange_jitter_s, {0.0, 1.0},
          "mean of the exponential part of their delay");
  setting(object, "free_running", s.free_running, "each sensor has its own phase, clock origin and drift");
  setting(object, "focal_spread_px", s.focal_spread_px, {0.0, 50.0}, "uniform in +-, between units");
  setting(object, "centre_spread_px", s.centre_spread_px, {0.0, 50.0}, "uniform in +-, between units");
  object.about({{"farthest_m", "at which a joint is seen"}});
  object.finish();
  return s;
}

MocapSpec read_mocap_spec(JsonObject object) {
  MocapSpec m;
  setting(object, "rate_hz", m.rate_hz, {1.0, 2000.0}, "of OptiTrack");
  setting(object, "marker_noise_sigma_m", m.marker_noise_sigma_m, {0.0, kUnlimited}, "an axis");
  setting(object, "marker_offset_m", m.marker_offset_m, {0.0, kUnlimited},
          "of each of a joint's four markers from the joint");
  setting(object, "gap_share", m.gap_share, {0.0, 1.0}, "of 0.2 s stretches in which a marker is lost");
  setting(object, "clock_error_s", m.clock_error_s, {0.0, 10.0},
          "uniform in +-, between the stated and the true start");
  object.finish();
  return m;
}

std::vector<Joint> joints_of_groups(const std::vector<std::string>& groups) {
  std::vector<Joint> joints;
  for (const JointGroup& group : joint_groups())
    for (const std::string& name : groups)
      if (name == group.name) joints.insert(joints.end(), group.joints.begin(), group.joints.end());
  return joints;
}

// The paper's markers: the upper body when walking, arms and legs in the two occlusion experiments.
std::vector<Joint> default_marker_joints(Activity activity) {
  return activity == Activity::leg_crossing ? joints_of_groups({"hip", "knee", "ankle"})
         : activity == Activity::arm_swing  ? joints_of_groups({"shoulder", "elbow", "wrist"})
                                            : joints_of_groups({"head", "shoulder", "elbow", "wrist"});
}

ActivitySpec read_activity(JsonObject& object) {
  ActivitySpec activity;
  activity.activity = static_cast<Activity>(object.choice("name", activity_names()));
  setting(object, "duration_s", activity.duration_s, {0.1, 1e6}, "of the take");
  activity.marker_joints = default_marker_joints(activity.activity);
  if (object.has("marker_joints")) {
    activity.marker_joints.clear();
    const auto names = object.texts("marker_joints");
    if (const std::string twice = first_repeated(names); !twice.empty())
      object.refuse("marker_joints", "names \"" + twice + "\" twice");
    for (const std::string& name : names) {
      const auto joint = joint_from_name(name);
      if (!joint)
        object.refuse("marker_joints",
                      "names \"" + name + "\", which is not a joint; " + known_names(name, joint_names()));
      activity.marker_joints.push_back(*joint);
    }
    if (activity.marker_joints.empty()) object.refuse("marker_joints", "must name at least one joint");
  }
  object.about({{"name", "what the person does"},
                {"marker_joints", "joints that carry markers; without it the paper's of the activity"}});
  object.finish();
  return activity;
}

}  // namespace

SimulationSpec parse_simulation(const Json& json, const std::string& place,
                                const std::filesystem::path& folder) {
  JsonObject object(json, place, "");
  SimulationSpec spec;
  object.format(kFormat);
  setting(object, "name", spec.name, "of the campaign");
  setting(object, "seed", spec.seed, "of every random number");
  setting(object, "participants", spec.participants, {1, 10'000}, "persons");
  if (object.has("stature_m")) {
    JsonObject stature = object.object("stature_m");
    setting(stature, "mean", spec.stature_mean_m, {0.5, 2.5}, "of the persons");
    setting(stature, "half_range", spec.stature_half_range_m, {0.0, 0.5}, "to both sides, uniform");
    if (spec.stature_mean_m - spec.stature_half_range_m < 0.5)
      stature.refuse("half_range", "must leave everybody at least 0.5 m tall");
    stature.finish();
  }
  if (object.has("recorded")) {
    JsonObject recorded = object.object("recorded");
    spec.recorded = RecordedSpec{path_of(recorded, "mocap", folder), path_of(recorded, "mapping", folder)};
    spec.recorded->activity = recorded.text("activity", spec.recorded->activity);
    spec.recorded->up_axis = read_up_axis(recorded);
    recorded.about({{"mocap", "its export, relative to this file"},
                    {"mapping", "of its assets to joints"},
                    {"activity", "what studies call it"},
                    {"up_axis", "of its world; y where it is not stated"}});
    recorded.finish();
  }
  if (object.has("activities"))
    for (JsonObject& entry : object.objects("activities")) spec.activities.push_back(read_activity(entry));
  for (const char* key : {"participants", "stature_m"})
    if (spec.recorded && object.has(key))
      object.refuse(key,
                    "has no effect beside \"recorded\": the recorded take has its one person; leave it out");
  if (spec.recorded && !spec.activities.empty())
    object.refuse("activities", "cannot stand beside \"recorded\": the recorded take is the activity");
  if (!spec.recorded && spec.activities.empty())
    spec.activities.push_back({Activity::walking, 35.0, default_marker_joints(Activity::walking)});
  if (object.has("rig")) spec.rig = read_rig(object.object("rig"));
  if (object.has("sensor")) spec.sensor = read_sensor(object.object("sensor"));
  if (object.has("body_tracker")) spec.body_tracker = read_body_tracker(object);
  object.shape("body_tracker", R"({"type": ["object", "string"]})");
  if (object.has("mocap")) spec.mocap = read_mocap_spec(object.object("mocap"));
  if (object.has("room")) spec.room = read_room(object.object("room"));
  if (object.has("depth")) spec.depth = read_depth_spec(object.object("depth"));
  if (object.has("wand")) spec.wand = read_wand_spec(object.object("wand"));
  if (object.has("bench")) spec.bench = read_bench_spec(object.object("bench"));
  const bool has_depth = spec.depth.takes || spec.wand || spec.bench;
  if (object.has("depth") && !has_depth)
    object.refuse("depth", "says nothing without \"takes\": true in it, or \"wand\" or \"bench\" beside it");
  if (object.has("room") && !has_depth)
    object.refuse("room",
                  "is not visible without depth: \"takes\": true in \"depth\", or \"wand\" or \"bench\"");
  object.about({{"stature_m", "of the persons"},
                {"recorded", "an OptiTrack take that is watched instead of generated persons"},
                {"activities", "of every person; without it walking"},
                {"rig", "where the virtual sensors stand"},
                {"sensor", "the virtual sensor"},
                {"body_tracker", "errors of its body tracker; or a body_tracker.json"},
                {"mocap", "the virtual OptiTrack"},
                {"room", "what depth sees besides persons"},
                {"depth", "errors of depth"},
                {"wand", "a calibration recording beside the takes"},
                {"bench", "recordings of a ball at stated distances, and of flat walls"}});
  object.finish();
  if (spec.recorded) spec.participants = 1;
  if (spec.participants * std::max<std::size_t>(1, spec.activities.size()) > 16'000)
    object.refuse("participants", "make more than 16000 takes with these activities");
  return spec;
}

SimulationSpec read_simulation(const std::filesystem::path& path) {
  Json json = read_json(path);
  if (json.is_object()) json.erase("scales");  // of `trilat reproduce`
  std::filesystem::path tracker;
  if (json.is_object() && json.contains("body_tracker") && json["body_tracker"].is_string()) {
    JsonObject object(json, path.string(), "");
    tracker = path_of(object, "body_tracker", path.parent_path());
    json["body_tracker"] = read_json(tracker);
  }
  SimulationSpec spec = parse_simulation(json, path.string(), path.parent_path());
  spec.body_tracker_file = tracker;
  return spec;
}

std::vector<SensorPose> rig_poses(const RigSpec& rig, const Eigen::Vector3d& default_centre_m) {
  const Eigen::Vector3d centre = rig.centre_m.value_or(default_centre_m);
  std::vector<SensorPose> poses;
  const double step = rig.arc_rad / static_cast<double>(rig.heights_m.size());
  for (std::size_t i = 0; i < rig.heights_m.size(); ++i) {
    const double angle = rig.arc_start_rad + step * (static_cast<double>(i) + 0.5);
    const Eigen::Vector3d position(centre.x() + rig.radius_m * std::sin(angle), rig.heights_m[i],
                                   centre.z() + rig.radius_m * std::cos(angle));
    SensorPose pose;
    pose.name = "k" + std::to_string(i + 1);
    pose.world_from_sensor = world_from_sensor_looking_at(position, centre);
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace trilat
