// SPDX-License-Identifier: MIT
#include "datasets/rig/calibration.h"

#include <array>
#include <cmath>
#include <set>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/words.h"

namespace trilat {
namespace {

constexpr double kUnitTolerance = 1e-3;
constexpr double kSamePlace_m = 0.01;  // two sensors cannot stand so close

using Covariance = Eigen::Matrix<double, 6, 6>;
using LowerTriangle = std::array<double, 21>;  // row by row

LowerTriangle lower_triangle_of(const Covariance& covariance) {
  LowerTriangle numbers;
  std::size_t next = 0;
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column <= row; ++column) numbers.at(next++) = covariance(row, column);
  return numbers;
}

Covariance symmetric(const LowerTriangle& numbers) {
  Covariance covariance;
  std::size_t next = 0;
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column <= row; ++column)
      covariance(row, column) = covariance(column, row) = numbers.at(next++);
  return covariance;
}

}  // namespace

void SensorPose::fields(SensorPose& self, Fields& f) {
  Eigen::Vector4d xyzw = self.world_from_sensor.rotation.coeffs();
  std::optional<LowerTriangle> lower;
  if (self.covariance) lower = lower_triangle_of(*self.covariance);
  const bool was_measured = self.used > 0;
  f("name", self.name, need("Name of the sensor"));
  f("position_m", self.world_from_sensor.translation_m, need("Position in the world", {-100.0, 100.0}));
  f("rotation_xyzw", xyzw, need("Unit quaternion that turns the sensor's frame into the world"));
  f("position_sigma_m", self.position_sigma_m,
    opt("Standard deviation, root mean square over the axes", {0.0, 100.0}));
  f("rotation_sigma_rad", self.rotation_sigma_rad,
    opt("Standard deviation, root mean square over the axes", {0.0, 10.0}));
  f("covariance", lower,
    opt("Lower triangle, row by row, of the covariance of (rotation vector in world axes, rad; position, "
        "m)"));
  if (f.writes_if(was_measured || self.depth_offset_m != 0.0 || self.depth_offset_sigma_m != 0.0)) {
    f("depth_offset_m", self.depth_offset_m,
      opt("Depth offset of the unit, subtracted from depth", {-0.5, 0.5}));
    f("depth_offset_sigma_m", self.depth_offset_sigma_m,
      opt("Standard deviation of that offset", {0.0, 100.0}));
  }
  if (f.writes_if(was_measured || self.residual_rms_m != 0.0))
    f("residual_rms_m", self.residual_rms_m,
      opt("Root mean square residual of the sightings used, an axis", {0.0, 100.0}));
  if (f.writes_if(was_measured || self.left_out > 0)) {
    f("used", self.used, opt("Number of sightings used"));
    f("left_out", self.left_out, opt("Number of sightings left out"));
  }
  if (!f.reads()) return;
  if (!(std::abs(xyzw.norm() - 1.0) <= kUnitTolerance))
    f.refuse("rotation_xyzw",
             fmt::format("must be a unit quaternion (x, y, z, w); its length is {:g}", xyzw.norm()));
  self.world_from_sensor.rotation = Eigen::Quaterniond(xyzw.normalized());
  if (lower) self.covariance = symmetric(*lower);
}

void SensorPose::check(const JsonPlace& place) const {
  if (!covariance) return;
  const Eigen::SelfAdjointEigenSolver<Covariance> eigen(*covariance, Eigen::EigenvaluesOnly);
  const double largest = eigen.eigenvalues()[5];
  if (!(eigen.eigenvalues()[0] >= -1e-9 * std::max(largest, 0.0)) || largest < 0.0)
    place.at("covariance").refuse("is not a covariance: its lower triangle gives a negative variance");
}

void Calibration::check(const JsonPlace& place) const {
  const std::string meant = nearest_name(world, {"optitrack", "wand"});
  if (!meant.empty() && meant != world)
    place.at("world").refuse("is \"" + world + "\"; did you mean \"" + meant + "\"?");
  std::set<std::string> names;
  for (std::size_t a = 0; a < sensors.size(); ++a) {
    if (!names.insert(sensors[a].name).second) place.at("sensors").at(a).at("name").refuse("is here twice");
    const auto& at_m = sensors[a].world_from_sensor.translation_m;
    for (std::size_t b = 0; b < a && method != kWithoutTranslation; ++b)
      if ((at_m - sensors[b].world_from_sensor.translation_m).norm() < kSamePlace_m)
        place.at("sensors").refuse(
            fmt::format("has \"{}\" and \"{}\" in one place; two sensors cannot stand within 1 cm",
                        sensors[b].name, sensors[a].name));
  }
}

Calibration read_calibration(const std::filesystem::path& path) {
  return read_as<Calibration>(read_json(path), path);
}

void write_calibration(const std::filesystem::path& path, const Calibration& calibration) {
  write_file(path, json_text(json_of(calibration), 2) + "\n");
}

const SensorPose& pose_of(const Calibration& calibration, const std::string& name, const std::string& place) {
  std::vector<std::string> known;
  for (const SensorPose& pose : calibration.sensors) {
    if (pose.name == name) return pose;
    known.push_back(pose.name);
  }
  throw InputError(place, "has no pose for sensor \"" + name + "\"; it has " + join_names(known));
}

}  // namespace trilat
