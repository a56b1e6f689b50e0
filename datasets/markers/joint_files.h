// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/units.h"

namespace trilat {

struct JointFrame {
  double time_s = 0.0;
  std::vector<Eigen::Vector3d> position_m;  // by joint; NaN: missing
  std::vector<double> sigma_m;              // by joint, or empty: not known
  std::vector<std::string_view> status;     // by joint, or empty: not known
};

// Joints over time, in a right-handed world. Frames follow each other at the rate, within half a period: an
// instant at which nothing is known is a frame whose joints are all missing.
struct JointTrack {
  std::vector<std::string> joints;
  double rate_hz = 30.0;
  std::int64_t frames = 0;                // how many there are
  std::function<void(JointFrame&)> next;  // gives the next one, in a frame that may hold an earlier one
};

// Each writes the whole track; an output that fails leaves no file. OutputError when the disk does not let
// us.

// A marker file as OpenSim reads it: millimetres to the micrometre, a missing joint is three empty cells.
void write_trc(const std::filesystem::path& path, const JointTrack& track);

inline constexpr const char* kJointCsvHead = "frame,time_s,joint,status,x_m,y_m,z_m,sigma_m\n";

// A row a frame and joint, blank where nothing is known.
void write_joint_csv(const std::filesystem::path& path, const JointTrack& track);

// The header rows of a TRC file.
std::string trc_header(const std::filesystem::path& path, const std::vector<std::string>& joints,
                       double rate_hz, std::int64_t frames, LengthUnit unit);

}  // namespace trilat
