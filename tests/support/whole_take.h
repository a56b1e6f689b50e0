// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/mocap/mocap_reader.h"

namespace trilat {

struct MocapTake {
  MocapHeader header;
  std::vector<MocapFrame> frames;
  MocapAnomalies anomalies;
};

inline MocapTake read_mocap(const std::filesystem::path& path) {
  MocapReader reader(path);
  MocapTake take;
  MocapFrame frame;
  while (reader.next(frame)) take.frames.push_back(frame);
  take.header = reader.header();
  take.anomalies = reader.anomalies();
  return take;
}

}  // namespace trilat
