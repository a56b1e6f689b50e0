// SPDX-License-Identifier: MIT
#include "datasets/calibration/calibration.h"

#include <cmath>
#include <set>

#include <Eigen/Eigenvalues>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/known_names.h"
#include "datasets/base/settings.h"

namespace trilat {
namespace {

constexpr const char* kFormat = "trilat.calibration";
constexpr double kUnitTolerance = 1e-3;
constexpr double kMaxDistance_m = 100.0;
constexpr double kSamePlace_m = 0.01;           // two sensors cannot stand so close
constexpr std::size_t kCovarianceNumbers = 21;  // of the lower triangle, row by row

constexpr Limits<double> kNotNegative{0.0, kUnlimited};

Eigen::Matrix<double, 6, 6> read_covariance(JsonObject& entry) {
  const auto numbers = entry.numbers("covariance", kCovarianceNumbers);
  Eigen::Matrix<double, 6, 6> covariance;
  std::size_t next = 0;
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column <= row; ++column)
      covariance(row, column) = covariance(column, row) = numbers[next++];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(covariance, Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues()[0] >= -1e-9 * std::max(eigen.eigenvalues()[5], 0.0)) ||
      eigen.eigenvalues()[5] < 0.0)
    entry.refuse("covariance", "is not a covariance: its lower triangle gives a negative variance");
  return covariance;
}

Json covariance_json(const Eigen::Matrix<double, 6, 6>& covariance) {
  Json numbers = Json::array();
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column <= row; ++column) numbers.push_back(covariance(row, column));
  return numbers;
}

SensorPose read_pose(JsonObject& entry) {
  SensorPose pose;
  pose.name = entry.text("name");
  const auto position = entry.numbers("position_m", 3);
  for (double value : position)
    if (std::abs(value) > kMaxDistance_m)
      entry.refuse("position_m", "lies beyond 100 m; is the unit metres?");
  const auto q = entry.numbers("rotation_xyzw", 4);
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (!(std::abs(rotation.norm() - 1.0) <= kUnitTolerance))
    entry.refuse("rotation_xyzw",
                 "must be a unit quaternion (x, y, z, w); its length is " + std::to_string(rotation.norm()));
  pose.world_from_sensor = {rotation.normalized(), {position[0], position[1], position[2]}};
  setting(entry, "position_sigma_m", pose.position_sigma_m, kNotNegative, "one standard deviation");
  setting(entry, "rotation_sigma_rad", pose.rotation_sigma_rad, kNotNegative, "one standard deviation");
  if (entry.has("covariance")) pose.covariance = read_covariance(entry);
  pose.depth_offset_m = entry.number("depth_offset_m", 0.0);
  if (std::abs(pose.depth_offset_m) > 0.5)
    entry.refuse("depth_offset_m", "is beyond half a metre; is the unit metres?");
  setting(entry, "depth_offset_sigma_m", pose.depth_offset_sigma_m, kNotNegative, "one standard deviation");
  setting(entry, "residual_rms_m", pose.residual_rms_m, kNotNegative, "of the sightings used");
  setting(entry, "used", pose.used, "sightings");
  setting(entry, "left_out", pose.left_out, "sightings");
  entry.about(
      {{"name", "of the sensor"},
       {"position_m", "in the world"},
       {"rotation_xyzw", "world from sensor, unit quaternion"},
       {"covariance", "lower triangle, row by row, of (rotation vector in world axes, rad; position, m)"},
       {"depth_offset_m", "of the unit, subtracted from depth"}});
  entry.finish();
  return pose;
}

void check_places(JsonObject& object, const std::vector<SensorPose>& sensors) {
  for (std::size_t a = 0; a < sensors.size(); ++a)
    for (std::size_t b = a + 1; b < sensors.size(); ++b)
      if ((sensors[a].world_from_sensor.translation_m - sensors[b].world_from_sensor.translation_m).norm() <
          kSamePlace_m)
        object.refuse("sensors", "has \"" + sensors[a].name + "\" and \"" + sensors[b].name +
                                     "\" in one place; two sensors cannot stand within 1 cm");
}

// A number that a document need not have.
void optional_number(JsonObject& object, const char* key, std::optional<double>& value, const char* meaning) {
  if (double number = 0.0; object.has(key)) {
    setting(object, key, number, kNotNegative, meaning);
    value = number;
  }
}

RejectedSighting read_rejected(JsonObject& entry) {
  RejectedSighting result{entry.text("sensor"), entry.count("position"), entry.number("time_s")};
  optional_number(entry, "off_by_m", result.off_by_m, "from where the others put it");
  entry.about(
      {{"sensor", "that saw the wand"}, {"position", "number of the place"}, {"time_s", "in the session"}});
  entry.finish();
  return result;
}

CalibrationSource read_source(JsonObject& entry) {
  const CalibrationSource result{entry.text("file"), entry.text("sha256")};
  entry.about({{"file", "session or other input"}, {"sha256", "of its content"}});
  entry.finish();
  return result;
}

Json pose_json(const SensorPose& pose) {
  const auto& t = pose.world_from_sensor.translation_m;
  const auto& q = pose.world_from_sensor.rotation;
  Json json{{"name", pose.name},
            {"position_m", {t.x(), t.y(), t.z()}},
            {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}},
            {"position_sigma_m", pose.position_sigma_m},
            {"rotation_sigma_rad", pose.rotation_sigma_rad}};
  if (pose.covariance) json["covariance"] = covariance_json(*pose.covariance);
  if (pose.depth_offset_m != 0.0 || pose.depth_offset_sigma_m != 0.0 || pose.used > 0) {
    json["depth_offset_m"] = pose.depth_offset_m;
    json["depth_offset_sigma_m"] = pose.depth_offset_sigma_m;
  }
  if (pose.residual_rms_m != 0.0 || pose.used > 0) json["residual_rms_m"] = pose.residual_rms_m;
  if (pose.used > 0 || pose.left_out > 0) {
    json["used"] = pose.used;
    json["left_out"] = pose.left_out;
  }
  return json;
}

}  // namespace

Calibration read_calibration(const std::filesystem::path& path) {
  return parse_calibration(read_json(path), path.string());
}

Calibration parse_calibration(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  object.format(kFormat);
  Calibration calibration;
  calibration.method = object.text("method");
  setting(object, "world", calibration.world, "whose frame the positions are in");
  setting(object, "simulated", calibration.simulated, "every table says so");
  setting(object, "positions", calibration.positions, "of the wand");
  optional_number(object, "reduced_chi2", calibration.reduced_chi2, "of the refinement");
  setting(object, "program", calibration.program, "version that wrote it");
  std::set<std::string> names;
  for (JsonObject& entry : object.objects("sensors")) {
    calibration.sensors.push_back(read_pose(entry));
    if (!names.insert(calibration.sensors.back().name).second) entry.refuse("name", "is here twice");
  }
  if (calibration.sensors.empty()) object.refuse("sensors", "must name at least one sensor");
  if (calibration.method != kWithoutTranslation) check_places(object, calibration.sensors);
  if (object.has("rejected"))
    for (JsonObject& entry : object.objects("rejected")) calibration.rejected.push_back(read_rejected(entry));
  if (object.has("sources"))
    for (JsonObject& entry : object.objects("sources")) calibration.sources.push_back(read_source(entry));
  object.about({{"method", "how the sensors were calibrated"},
                {"sensors", "with their poses"},
                {"rejected", "sightings"},
                {"sources", "what it was computed from"}});
  object.finish();
  return calibration;
}

Json calibration_json(const Calibration& calibration) {
  Json json{{"format", kFormat},
            {"version", 1},
            {"method", calibration.method},
            {"world", calibration.world},
            {"simulated", calibration.simulated},
            {"sensors", Json::array()}};
  for (const SensorPose& pose : calibration.sensors) json["sensors"].push_back(pose_json(pose));
  if (calibration.positions > 0) json["positions"] = calibration.positions;
  if (calibration.reduced_chi2) json["reduced_chi2"] = *calibration.reduced_chi2;
  for (const RejectedSighting& r : calibration.rejected) {
    json["rejected"].push_back({{"sensor", r.sensor}, {"position", r.position}, {"time_s", r.time_s}});
    if (r.off_by_m) json["rejected"].back()["off_by_m"] = *r.off_by_m;
  }
  for (const CalibrationSource& s : calibration.sources)
    json["sources"].push_back({{"file", s.file}, {"sha256", s.sha256}});
  if (!calibration.program.empty()) json["program"] = calibration.program;
  return json;
}

void write_calibration(const std::filesystem::path& path, const Calibration& calibration) {
  write_file(path, json_text(calibration_json(calibration), 2) + "\n");
}

const SensorPose& pose_of(const Calibration& calibration, const std::string& name, const std::string& place) {
  std::vector<std::string> known;
  for (const SensorPose& pose : calibration.sensors) {
    if (pose.name == name) return pose;
    known.push_back(pose.name);
  }
  throw InputError(place, "has no pose for sensor \"" + name + "\"; it has " + listed(known));
}

}  // namespace trilat
