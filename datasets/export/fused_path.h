// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/skeleton/skeleton.h"

namespace trilat {

// A person's joints as several sensors together see them, at equal steps of time.
struct FusedPath {
  double rate_hz = 30.0;
  std::int64_t start_host_ns = 0;  // of the first instant, on the recording's host clock
  std::vector<Joint> joints;
  struct Point {
    Eigen::Vector3f position_m = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
    float sigma_m = std::numeric_limits<float>::quiet_NaN();  // an axis, of the method's own model
    std::uint8_t status = 0;                                  // into status_names
    bool is_usable = false;
  };
  std::vector<Point> points;  // instants times joints
  std::vector<std::string> status_names;

  std::size_t instants() const { return joints.empty() ? 0 : points.size() / joints.size(); }
  double seconds(std::size_t instant) const { return static_cast<double>(instant) / rate_hz; }
};

inline constexpr const char* kFusedCsvHead = "time_s,joint,status,x_m,y_m,z_m,sigma_m\n";

// One row an instant and joint; a position that is not usable, and a sigma that is not known, are empty.
void write_fused_csv(const FusedPath& path, const std::filesystem::path& output);

// Marker file as OpenSim reads it, every joint a marker in the skeleton's order.
void write_fused_trc(const FusedPath& path, const std::filesystem::path& output, bool millimetres);

}  // namespace trilat
