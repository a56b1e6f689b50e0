// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/time.h"
#include "datasets/mocap/read_mocap.h"

namespace trilat {

// Points, each the mean of some markers, as a function of time. Each marker is interpolated by itself between
// its two nearest samples, never across more than `longest_gap`; frozen stretches are no samples. A point is
// there only when all of its markers are: the mean of the rest would be another point.
class MarkerTrack {
 public:
  // `has_z_up`: it is turned so that y is up. A point without markers is never there.
  MarkerTrack(MocapTake positions, std::vector<std::vector<std::size_t>> markers_of_point,
              Duration longest_gap, bool has_z_up);

  // The points in the world, metres, NaN where there is none. Time since the first frame.
  void at(MocapTime t, std::span<Eigen::Vector3d> points) const;
  MocapTime end() const;  // the last frame's time
  const MocapTake& positions() const { return positions_; }
  // Whether each frame holds the same positions as the frame before, to the bit.
  std::vector<bool> repeated_frames() const;

 private:
  Eigen::Vector3d marker_at(std::size_t marker, std::size_t after, MocapTime t) const;

  MocapTake positions_;
  std::vector<std::vector<std::size_t>> markers_of_point_;
  Duration longest_gap_;
  bool has_z_up_;
};

// Notes on oddities of its frames and positions.
std::vector<std::string> suspicious_names(const MarkerTrack& track);

}  // namespace trilat
