// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/mocap/read_mocap.h"

namespace trilat {

// A motion capture as it is written, frame by frame.
struct WholeTake {
  struct Pose {
    Eigen::Vector3d position_m;
    bool has_position() const { return position_m.allFinite(); }
  };
  struct Frame {
    std::int64_t index = 0;
    MocapTime time;
    std::vector<Pose> poses;  // by asset; missing where it was not read
  };
  MocapHeader header;
  std::vector<Frame> frames;
  MocapAnomalies anomalies;
};

inline WholeTake whole_take(const std::filesystem::path& path, const MocapPart& part = {}) {
  const MocapTake take = read_mocap(path, part);
  WholeTake whole{take.header, {}, take.anomalies};
  for (std::size_t f = 0; f < take.time.size(); ++f) {
    WholeTake::Frame& frame = whole.frames.emplace_back(WholeTake::Frame{take.frame[f], take.time[f], {}});
    for (const std::vector<Eigen::Vector3d>& position_m : take.position_m)
      frame.poses.push_back({position_m.empty() ? Eigen::Vector3d::Constant(kNaN) : position_m[f]});
  }
  return whole;
}

}  // namespace trilat
