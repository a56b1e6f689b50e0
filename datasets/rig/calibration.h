// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/rig/rigid_transform.h"

namespace trilat {

// Pose of a sensor in the world, and its uncertainty (one standard deviation; 0 when exact).
struct SensorPose {
  std::string name;
  RigidTransform world_from_sensor;
  double position_sigma_m = 0.0;    // root mean square over the axes
  double rotation_sigma_rad = 0.0;  // root mean square over the axes
  // Covariance of (rotation vector in world axes, rad; position, m).
  std::optional<Eigen::Matrix<double, 6, 6>> covariance = std::nullopt;
  // How much farther than true the sensor's depth is, and how sure that is.
  double depth_offset_m = 0.0;
  double depth_offset_sigma_m = 0.0;
  // Measurements that made the pose: root mean square residual an axis, number of those used, and of those
  // left out because they disagreed.
  double residual_rms_m = 0.0;
  std::uint64_t used = 0;
  std::uint64_t left_out = 0;

  static void fields(SensorPose& self, Fields& f);
  void check(const JsonPlace& place) const;
};

// A measurement that disagreed with all others.
struct RejectedSighting {
  std::string sensor;
  std::uint64_t position = 0;                     // from 1, in the order of time
  double time_s = 0.0;                            // since the recording's first frame
  std::optional<double> off_by_m = std::nullopt;  // from where the others put it; empty where two disagree

  static void fields(auto& self, auto&& f) {
    f("sensor", self.sensor, need("Sensor that saw the wand"));
    f("position", self.position, need("Number of the place"));
    f("time_s", self.time_s, need("Time in the session"));
    f("off_by_m", self.off_by_m,
      opt("Distance from where the others put the ball; left out where two sensors disagree", kNotNegative));
  }
};

// Input that a calibration was made from.
struct CalibrationSource {
  std::string file;
  std::string sha256;

  static void fields(auto& self, auto&& f) {
    f("file", self.file, need("Session or other input"));
    f("sha256", self.sha256, need("SHA-256 of its content"));
  }
};

// The method of poses that a simulation knows.
inline constexpr const char* kSimulatedTruth = "simulated truth";

// calibration.json, format 1. `method` says how it was made ("simulated truth", "wand", "bodies", …), `world`
// where the poses' world is.
struct Calibration {
  std::string method;
  std::vector<SensorPose> sensors;
  std::string world = "optitrack";
  bool simulated = false;
  std::uint64_t positions = 0;  // of the wand, or joints at instants
  // Reduced chi-squared of the refinement; 1: residuals are as large as their covariances say. Empty where it
  // is not known.
  std::optional<double> reduced_chi2 = std::nullopt;
  std::vector<RejectedSighting> rejected = {};
  std::vector<CalibrationSource> sources = {};
  std::string program = {};

  static void fields(auto& self, auto&& f) {
    f.format("trilat.calibration");
    f("method", self.method, need("Way in which the sensors were calibrated"));
    f("world", self.world,
      opt("World of the poses: optitrack; wand, whose origin is the wand's first place, with x towards the "
          "second and the third on the side of y; or a sensor's name"));
    f("simulated", self.simulated, opt("Whether the sensors are virtual; every table says so"));
    f("sensors", self.sensors, need("Sensors with their poses").items(1));
    if (f.writes_if(self.positions > 0)) f("positions", self.positions, opt("Number of places of the wand"));
    f("reduced_chi2", self.reduced_chi2, opt("Reduced chi-squared of the refinement", kNotNegative));
    if (f.writes_if(!self.rejected.empty()))
      f("rejected", self.rejected, opt("Sightings that were left out"));
    if (f.writes_if(!self.sources.empty()))
      f("sources", self.sources, opt("Files that it was computed from"));
    if (f.writes_if(!self.program.empty()))
      f("program", self.program, opt("Version of the program that wrote it"));
  }
  void check(const JsonPlace& place) const;
};

// The method of eq. 7 as printed, which leaves every sensor at the origin (erratum E5).
inline constexpr const char* kWithoutTranslation = "two positions, as printed";

// Refuses what cannot be: sensors named twice or in one place (unless kWithoutTranslation), quaternions that
// are not unit (beyond 1e-3), positions beyond 100 m, covariances that are not positive semidefinite.
Calibration read_calibration(const std::filesystem::path& path);
void write_calibration(const std::filesystem::path& path, const Calibration& calibration);

// The pose of `name`; InputError at `place` listing the calibrated sensors.
const SensorPose& pose_of(const Calibration& calibration, const std::string& name, const std::string& place);

}  // namespace trilat
