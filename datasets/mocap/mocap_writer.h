// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/text_output.h"
#include "datasets/base/units.h"
#include "datasets/mocap/mocap_take.h"

namespace trilat {

// Writes the positions of a take as Motive 1.25 lays it out: in the header's unit with six decimals; what is
// missing is an empty cell. Streams beside the final name and takes it only in finish(); without that the
// partial file is removed.
class OptitrackCsvWriter {
 public:
  // Uses of `header` the names, rates, counts, length unit and assets. Rates must be stated.
  // OutputError when the file cannot be written.
  OptitrackCsvWriter(const std::filesystem::path& path, MocapHeader header);

  // A position for each asset of the header, NaN where it is missing. The printed time is frame / export
  // rate.
  void write(std::int64_t frame, std::span<const Eigen::Vector3d> position_m);
  // The number of frames must be the one the header states, when it states one.
  void finish();

 private:
  void write_header();

  TextOutput file_;
  MocapHeader header_;
  double per_metre_;
  std::string row_;
  std::int64_t frames_ = 0;
};

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
