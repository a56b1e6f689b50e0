// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "datasets/mocap/mocap_reader.h"

namespace trilat {

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
