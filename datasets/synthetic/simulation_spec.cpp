// SPDX-License-Identifier: MIT
#include "datasets/synthetic/simulation_spec.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"
#include "datasets/base/units.h"
#include "datasets/base/words.h"
#include "datasets/synthetic/generated_person.h"

namespace trilat {
namespace {

constexpr const char* kPaper = "Yang, Dong, El Saddik, arXiv 2212.14771";
constexpr const char* kAssumption = "assumption: no published figure";
constexpr const char* kCalibrations = "public calibrations of Kinect v2 units";
constexpr const char* kSensor = "Kinect for Windows SDK 2.0 documentation";

std::string text(double value) { return fmt::format("{:g}", value); }
std::string between(double half) { return fmt::format("+-{:g}", half); }

void add_persons(const SimulationSpec& s, std::vector<SimulationAssumption>& list) {
  list.push_back({"participants", std::to_string(s.participants), "", kPaper});
  if (s.recorded) {
    list.push_back({"motion", "recorded take", "", s.recorded->mocap.filename().string()});
  } else {
    list.push_back({"stature", text(s.stature.mean_m) + between(s.stature.half_range_m), "m", kPaper});
    list.push_back(
        {"segments", "fractions of the stature", "", "Drillis and Contini 1966, as tabulated by Winter"});
  }
}

void add_rig(const RigSpec& rig, std::vector<SimulationAssumption>& list) {
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

void add_sensor(const SensorSpec& s, std::vector<SimulationAssumption>& list) {
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

void add_mocap(const MocapSpec& m, std::vector<SimulationAssumption>& list) {
  list.push_back({"mocap rate", text(m.rate_hz), "Hz", "OptiTrack V100:R2 of the paper"});
  list.push_back({"marker noise", text(m.marker_noise_sigma_m), "m, sigma an axis", kAssumption});
  list.push_back({"marker gaps", text(m.gap_share), "of 0.2 s stretches", kAssumption});
  list.push_back({"error of the stated start", between(m.clock_error_s), "s", kPaper});
}

}  // namespace

std::vector<SimulationAssumption> simulation_parameters(const SimulationSpec& spec) {
  std::vector<SimulationAssumption> list;
  add_persons(spec, list);
  add_rig(spec.rig, list);
  add_sensor(spec.sensor, list);
  for (SimulationAssumption& parameter : tracker_parameters(spec.body_tracker))
    list.push_back(std::move(parameter));
  if (!spec.recorded) add_mocap(spec.mocap, list);
  return list;
}

namespace {

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
struct HeightRange {
  std::uint64_t sensors = 4;
  double mean_m = 1.4, spread_m = 1.6, order = 0.0;

  static void fields(auto& self, auto&& f) {
    f("sensors", self.sensors, opt("Number of sensors", {1.0, 8.0}));
    f("mean_m", self.mean_m, opt("Mean height", {0.1, 5.0}));
    f("spread_m", self.spread_m, opt("Difference between the lowest and the highest", {0.0, 5.0}));
    f("order", self.order,
      opt("Share of all orders of the heights around the circle, from rising to falling", {0.0, 1.0}));
  }
  void check(const JsonPlace& place) const {
    if (mean_m < 0.5 * spread_m)
      place.at("spread_m")
          .refuse(fmt::format("is {:g} about a height of {:g} m, which puts sensors below the floor",
                              spread_m, mean_m));
  }
};

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

}  // namespace

void RigSpec::Heights::read(const Json& json, const JsonPlace& place, const About& about) {
  if (!json.is_object()) {
    json_value::read_value(json, place, about, static_cast<std::vector<double>&>(*this));
    return;
  }
  const auto range = read_as<HeightRange>(json, place);
  clear();
  for (const std::size_t k : permutation_at(range.order, range.sensors)) {
    const double step =
        range.sensors == 1 ? 0.5 : static_cast<double>(k) / static_cast<double>(range.sensors - 1);
    push_back(range.mean_m + (step - 0.5) * range.spread_m);
  }
}

Json RigSpec::Heights::schema(const About& about) {
  Json schema = json_value::struct_schema(HeightRange{});
  schema.update(json_value::schema(std::vector<double>{}, about));
  schema["type"] = {"array", "object"};
  return schema;
}

void ActivitySpec::fields(ActivitySpec& self, Fields& f) {
  f("name", self.activity, need("Movement of the person"));
  f("duration_s", self.duration_s, opt("Length of the take", {0.1, 1e6}));
  std::vector<std::string> names;
  for (const Joint joint : default_marker_joints(self.activity)) names.emplace_back(name_of(joint));
  if (f.has("marker_joints", false)) {
    f("marker_joints", names,
      opt("Joints that carry markers; without it the paper's of the activity")
          .items(1)
          .one_of(joint_names()));
  }
  if (f.reads())
    for (const std::string& name : names) self.marker_joints.push_back(joint_from_name(name).value());
}

void SimulationSpec::fields(SimulationSpec& self, Fields& f) {
  f.format("trilat.simulation");
  f("name", self.name, opt("Name of the campaign"));
  f("seed", self.seed, opt("Seed of every random number"));
  f("participants", self.participants, opt("Number of persons", {1.0, 10'000.0}));
  f("stature_m", self.stature, opt("Stature of the persons"));
  f("recorded", self.recorded, opt("OptiTrack take that is watched instead of generated persons"));
  f("activities", self.activities, opt("Activities of every person; without it walking"));
  f("rig", self.rig, opt("Places of the virtual sensors"));
  f("sensor", self.sensor, opt("Virtual sensor"));
  f("body_tracker", self.body_tracker,
    opt("Body tracker's values that differ from the declared ones, or the file or content of a "
        "body_tracker.json. Sigmas are per axis. Values of joints are one number for all, or an object of "
        "groups; 0 switches an error off. Bias and drift are sums of a part that all sensors share, one that "
        "goes with the direction of view (view_, as cosine and sine of the body's azimuth) and one of each "
        "sensor (own_)"));
  f("mocap", self.mocap, opt("Virtual OptiTrack"));
  f("room", self.room, opt("Surroundings that depth sees besides persons"));
  f("depth", self.depth, opt("Errors of depth"));
  f("wand", self.wand, opt("Calibration recording beside the takes, in the folder wand"));
  f("bench", self.bench,
    opt("Recordings in which all sensors stand at one point and look at a ball at stated distances, and "
        "squarely at flat walls"));
  if (!f.reads()) return;
  for (const char* key : {"participants", "stature_m"})
    if (self.recorded && f.has(key, false))
      f.refuse(key, "has no effect beside \"recorded\": the recorded take has its one person; leave it out");
  const bool has_depth = self.depth.takes || self.wand || self.bench;
  if (f.has("depth", false) && !has_depth)
    f.refuse("depth", "says nothing without \"takes\": true in it, or \"wand\" or \"bench\" beside it");
  if (f.has("room", false) && !has_depth)
    f.refuse("room", "is not visible without depth: \"takes\": true in \"depth\", or \"wand\" or \"bench\"");
}

void SimulationSpec::check(const JsonPlace& place) const {
  if (recorded && !activities.empty())
    place.at("activities").refuse("cannot stand beside \"recorded\": the recorded take is the activity");
  constexpr std::size_t kMaxTakes = 16'000;
  if (participants * std::max<std::size_t>(1, activities.size()) > kMaxTakes)
    place.at("participants").refuse(fmt::format("make more than {} takes with these activities", kMaxTakes));
}

Json simulation_schema() { return schema_of<SimulationSpec>(); }

SimulationSpec parse_simulation(const Json& json, const std::string& place,
                                const std::filesystem::path& folder) {
  auto spec = read_as<SimulationSpec>(json, {place, folder});
  if (spec.recorded) spec.participants = 1;
  if (!spec.recorded && spec.activities.empty())
    spec.activities.push_back({Activity::walking, 35.0, default_marker_joints(Activity::walking)});
  return spec;
}

SimulationSpec read_simulation(const std::filesystem::path& path) {
  Json json = read_json(path);
  if (json.is_object()) json.erase("scales");  // of `trilat reproduce`
  return parse_simulation(json, path.string(), path.parent_path());
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

Calibration perturbed(Calibration calibration, double sigma_m, double sigma_rad, std::uint64_t seed) {
  for (std::size_t s = 0; s < calibration.sensors.size(); ++s) {
    const RandomStream random{seed, Purpose::calibration_error, s};
    const Eigen::Vector3d turn =
        sigma_rad * Eigen::Vector3d(random.normal(0), random.normal(1), random.normal(2));
    SensorPose& pose = calibration.sensors[s];
    const double angle = turn.norm();
    if (angle > 0.0)
      pose.world_from_sensor.rotation =
          (Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) * pose.world_from_sensor.rotation)
              .normalized();
    pose.world_from_sensor.translation_m +=
        sigma_m * Eigen::Vector3d(random.normal(3), random.normal(4), random.normal(5));
    pose.position_sigma_m = sigma_m;
    pose.rotation_sigma_rad = sigma_rad;
  }
  calibration.method = "simulated truth, perturbed";
  return calibration;
}

}  // namespace trilat
