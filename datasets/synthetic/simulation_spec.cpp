// SPDX-License-Identifier: MIT
#include "datasets/synthetic/simulation_spec.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/strict_json.h"
#include "datasets/base/units.h"
#include "datasets/synthetic/generated_person.h"

namespace trilat {
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
  const std::uint64_t sensors = count_within(object, "sensors", 4, 1, 8);
  const double mean_m = number_within(object, "mean_m", 1.4, 0.1, 5.0);
  const double spread_m = number_within(object, "spread_m", 1.6, 0.0, 5.0);
  const double order = share_within(object, "order", 0.0);
  object.about({{"sensors", "how many"},
                {"mean_m", "height"},
                {"spread_m", "between the lowest and the highest"},
                {"order", "share of all orders around the circle, from rising to falling heights"}});
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
  rig.radius_m = number_within(object, "radius_m", rig.radius_m, 0.3, 20.0);
  if (object.has("heights_m")) {
    if (object.value("heights_m").is_object()) {
      rig.heights_m = read_height_range(object.object("heights_m"));
    } else {
      const std::size_t sensors = object.value("heights_m").size();
      if (sensors < 1 || sensors > 8) object.refuse("heights_m", "must hold 1 to 8 heights, one a sensor");
      rig.heights_m = object.numbers("heights_m", sensors);
    }
  }
  rig.arc_rad = kRadPerDegree * number_within(object, "arc_deg", rig.arc_rad / kRadPerDegree, 1.0, 360.0);
  rig.position_sigma_m = number_within(object, "position_sigma_m", rig.position_sigma_m, 0.0, 1.0);
  rig.rotation_sigma_rad = kRadPerDegree * number_within(object, "rotation_sigma_deg",
                                                         rig.rotation_sigma_rad / kRadPerDegree, 0.0, 45.0);
  if (object.has("centre_m")) {
    const auto c = object.numbers("centre_m", 3);
    rig.centre_m = Eigen::Vector3d(c[0], c[1], c[2]);
  }
  object.about({{"radius_m", "of the circle on which the sensors stand"},
                {"heights_m", "one a sensor, or an object of sensors, mean_m, spread_m and order"},
                {"arc_deg", "of the circle, in equal parts: a sensor stands in the middle of each"},
                {"position_sigma_m", "error of the calibration that is written, an axis"},
                {"rotation_sigma_deg", "and of its rotations"},
                {"centre_m", "where they look; without it (0, 1, 0), or the middle of a recorded take"}});
  object.finish();
  return rig;
}

SensorSpec read_sensor(JsonObject object) {
  SensorSpec s;
  s.rate_hz = number_within(object, "rate_hz", s.rate_hz, 1.0, 1000.0);
  s.nearest_m = not_negative(object, "nearest_m", s.nearest_m);
  s.farthest_m = object.positive("farthest_m", s.farthest_m);
  if (s.farthest_m <= s.nearest_m) object.refuse("farthest_m", "must be farther than nearest_m");
  object.gone("joint_bias_sigma_m", "say \"bias_sigma_m\" in \"body_tracker\"");
  object.gone("joint_noise_sigma_m", "say \"jitter_sigma_m\" in \"body_tracker\"");
  for (const char* key : {"inferred_share", "inferred_noise_factor"})
    object.gone(key, "joints are inferred where they are hidden; see \"body_tracker\"");
  s.dropped_share = share_within(object, "dropped_share", s.dropped_share);
  s.clock_drift_ppm = number_within(object, "clock_drift_ppm", s.clock_drift_ppm, 0.0, 500.0);
  s.latency_s = number_within(object, "latency_s", s.latency_s, 0.0, 1.0);
  s.arrival_jitter_s = number_within(object, "arrival_jitter_s", s.arrival_jitter_s, 0.0, 1.0);
  s.exchange_period_s = number_within(object, "exchange_period_s", s.exchange_period_s, 0.01, 3600.0);
  s.exchange_jitter_s = number_within(object, "exchange_jitter_s", s.exchange_jitter_s, 0.0, 1.0);
  s.free_running = object.boolean("free_running", s.free_running);
  s.focal_spread_px = number_within(object, "focal_spread_px", s.focal_spread_px, 0.0, 50.0);
  s.centre_spread_px = number_within(object, "centre_spread_px", s.centre_spread_px, 0.0, 50.0);
  object.about({{"rate_hz", "of frames"},
                {"nearest_m", "at which a joint is seen"},
                {"farthest_m", "at which a joint is seen"},
                {"dropped_share", "of frames"},
                {"clock_drift_ppm", "uniform in +-, of sensor and machine"},
                {"latency_s", "exposure to arrival, the constant part"},
                {"arrival_jitter_s", "mean of the exponential part"},
                {"exchange_period_s", "between two exchanges of clock messages"},
                {"exchange_jitter_s", "mean of the exponential part of their delay"},
                {"free_running", "each sensor has its own phase, clock origin and drift"},
                {"focal_spread_px", "uniform in +-, between units"},
                {"centre_spread_px", "uniform in +-, between units"}});
  object.finish();
  return s;
}

MocapSpec read_mocap_spec(JsonObject object) {
  MocapSpec m;
  m.rate_hz = number_within(object, "rate_hz", m.rate_hz, 1.0, 2000.0);
  m.marker_noise_sigma_m = not_negative(object, "marker_noise_sigma_m", m.marker_noise_sigma_m);
  m.marker_offset_m = not_negative(object, "marker_offset_m", m.marker_offset_m);
  m.gap_share = share_within(object, "gap_share", m.gap_share);
  m.clock_error_s = number_within(object, "clock_error_s", m.clock_error_s, 0.0, 10.0);
  object.about({{"rate_hz", "of OptiTrack"},
                {"marker_noise_sigma_m", "an axis"},
                {"marker_offset_m", "of each of a joint's four markers from the joint"},
                {"gap_share", "of 0.2 s stretches in which a marker is lost"},
                {"clock_error_s", "uniform in +-, between the stated and the true start"}});
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
  activity.duration_s = number_within(object, "duration_s", activity.duration_s, 0.1, 1e6);
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
                      "names \"" + name + "\", which is no joint; known are: " + joint_names());
      activity.marker_joints.push_back(*joint);
    }
    if (activity.marker_joints.empty()) object.refuse("marker_joints", "must name at least one joint");
  }
  object.about({{"name", "what the person does"},
                {"duration_s", "of the take"},
                {"marker_joints", "joints that carry markers; without it the paper's of the activity"}});
  object.finish();
  return activity;
}

}  // namespace

SimulationSpec parse_simulation(const Json& json, const std::string& place,
                                const std::filesystem::path& folder, OutsidePaths outside) {
  JsonObject object(json, place, "");
  SimulationSpec spec;
  object.format(kFormat);
  spec.name = object.text("name", spec.name);
  spec.seed = object.count("seed", spec.seed);
  spec.participants = count_within(object, "participants", spec.participants, 1, 10'000);
  if (object.has("stature_m")) {
    JsonObject stature = object.object("stature_m");
    spec.stature_mean_m = number_within(stature, "mean", spec.stature_mean_m, 0.5, 2.5);
    spec.stature_half_range_m = number_within(stature, "half_range", spec.stature_half_range_m, 0.0, 0.5);
    if (spec.stature_mean_m - spec.stature_half_range_m < 0.5)
      stature.refuse("half_range", "must leave everybody at least 0.5 m tall");
    stature.about({{"mean", "of the persons"}, {"half_range", "to both sides, uniform"}});
    stature.finish();
  }
  if (object.has("recorded")) {
    JsonObject recorded = object.object("recorded");
    spec.recorded = RecordedSpec{path_within(recorded, "mocap", folder, outside),
                                 path_within(recorded, "mapping", folder, outside)};
    spec.recorded->activity = recorded.text("activity", spec.recorded->activity);
    recorded.about({{"mocap", "its export, relative to this file"},
                    {"mapping", "of its assets to joints"},
                    {"activity", "what studies call it"}});
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
  if (object.has("body_tracker")) spec.body_tracker = read_body_tracker(object.object("body_tracker"));
  spec.bystanders = count_within(object, "bystanders", spec.bystanders, 0, kMostBystanders);
  if (object.has("mocap")) spec.mocap = read_mocap_spec(object.object("mocap"));
  if (object.has("room")) spec.room = read_room(object.object("room"));
  if (object.has("depth")) spec.depth = read_depth_spec(object.object("depth"));
  if (object.has("wand")) spec.wand = read_wand_spec(object.object("wand"));
  if (object.has("depth") && !spec.depth.takes && !spec.wand)
    object.refuse("depth", "says nothing without \"takes\": true in it or \"wand\" beside it");
  if (object.has("room") && !spec.depth.takes && !spec.wand)
    object.refuse("room", "is seen by nobody without depth: \"takes\": true in \"depth\", or \"wand\"");
  object.about({{"name", "of the campaign"},
                {"seed", "of every random number"},
                {"participants", "persons"},
                {"stature_m", "of the persons"},
                {"recorded", "an OptiTrack take that is watched instead of generated persons"},
                {"activities", "of every person; without it walking"},
                {"rig", "where the virtual sensors stand"},
                {"sensor", "the virtual sensor"},
                {"body_tracker", "errors of its body tracker"},
                {"bystanders", "who walk through the room"},
                {"mocap", "the virtual OptiTrack"},
                {"room", "what depth sees besides persons"},
                {"depth", "errors of depth"},
                {"wand", "a calibration recording beside the takes"}});
  object.finish();
  if (spec.recorded) spec.participants = 1;
  if (spec.participants * std::max<std::size_t>(1, spec.activities.size()) > 16'000)
    object.refuse("participants", "make more than 16000 takes with these activities");
  return spec;
}

SimulationSpec read_simulation(const std::filesystem::path& path, OutsidePaths outside) {
  return parse_simulation(read_json(path), path.string(), path.parent_path(), outside);
}

std::vector<SensorPose> rig_poses(const RigSpec& rig, const Eigen::Vector3d& default_centre_m) {
  const Eigen::Vector3d centre = rig.centre_m.value_or(default_centre_m);
  std::vector<SensorPose> poses;
  const double step = rig.arc_rad / static_cast<double>(rig.heights_m.size());
  for (std::size_t i = 0; i < rig.heights_m.size(); ++i) {
    const double angle = step * (static_cast<double>(i) + 0.5);
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
