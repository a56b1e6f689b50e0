// SPDX-License-Identifier: MIT
#include "datasets/calibration/calibration.h"

#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {
namespace {

constexpr const char* kFormat = "trilat.calibration";
constexpr double kUnitTolerance = 1e-3;
constexpr double kFarthest_m = 100.0;

SensorPose read_pose(JsonObject& entry) {
  SensorPose pose;
  pose.name = entry.text("name");
  const auto position = entry.numbers("position_m", 3);
  for (double value : position)
    if (std::abs(value) > kFarthest_m) entry.refuse("position_m", "lies beyond 100 m; is the unit metres?");
  const auto q = entry.numbers("rotation_xyzw", 4);
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (std::abs(rotation.norm() - 1.0) > kUnitTolerance)
    entry.refuse("rotation_xyzw",
                 "must be a unit quaternion (x, y, z, w); its length is " + std::to_string(rotation.norm()));
  pose.world_from_sensor = {rotation.normalized(), {position[0], position[1], position[2]}};
  pose.position_sigma_m = entry.number("position_sigma_m", pose.position_sigma_m);
  pose.rotation_sigma_rad = entry.number("rotation_sigma_rad", pose.rotation_sigma_rad);
  if (pose.position_sigma_m < 0.0) entry.refuse("position_sigma_m", "must not be negative");
  if (pose.rotation_sigma_rad < 0.0) entry.refuse("rotation_sigma_rad", "must not be negative");
  entry.finish();
  return pose;
}

}  // namespace

Calibration read_calibration(const std::filesystem::path& path) {
  const Json json = read_json(path);
  JsonObject object(json, path.string(), "");
  if (object.text("format") != kFormat) object.refuse("format", std::string("must be \"") + kFormat + '"');
  if (object.integer("version") != 1) object.refuse("version", "must be 1");
  Calibration calibration;
  calibration.method = object.text("method");
  std::set<std::string> names;
  for (JsonObject& entry : object.objects("sensors")) {
    calibration.sensors.push_back(read_pose(entry));
    if (!names.insert(calibration.sensors.back().name).second) entry.refuse("name", "stands here twice");
  }
  if (calibration.sensors.empty()) object.refuse("sensors", "must name at least one sensor");
  object.finish();
  return calibration;
}

void write_calibration(const std::filesystem::path& path, const Calibration& calibration) {
  Json json{{"format", kFormat}, {"version", 1}, {"method", calibration.method}, {"sensors", Json::array()}};
  for (const SensorPose& pose : calibration.sensors) {
    const auto& t = pose.world_from_sensor.translation_m;
    const auto& q = pose.world_from_sensor.rotation;
    json["sensors"].push_back({{"name", pose.name},
                               {"position_m", {t.x(), t.y(), t.z()}},
                               {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}},
                               {"position_sigma_m", pose.position_sigma_m},
                               {"rotation_sigma_rad", pose.rotation_sigma_rad}});
  }
  write_file(path, json.dump(2) + "\n");
}

const SensorPose& pose_of(const Calibration& calibration, const std::string& name, const std::string& place) {
  std::string known;
  for (const SensorPose& pose : calibration.sensors) {
    if (pose.name == name) return pose;
    known += (known.empty() ? "" : ", ") + pose.name;
  }
  throw InputError(place, "has no pose for sensor \"" + name + "\"; it has " + known);
}

}  // namespace trilat
