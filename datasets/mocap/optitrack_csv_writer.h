// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "datasets/mocap/mocap_take.h"

namespace trilat {

// Writes markers in Motive's column layout 1.25, metres, six decimals, missing as empty cells. The file has
// the name `path`.partial until finish().
class OptitrackCsvWriter {
 public:
  struct Take {
    std::string name;
    std::string capture_start;  // as Motive prints it, "2026-01-31 09.15.00.000 AM"; may be empty
    double rate_hz = 100.0;
    std::uint64_t frames = 0;
    std::vector<std::string> markers;
  };
  OptitrackCsvWriter(const std::filesystem::path& path, const Take& take);
  // The next frame; one position a marker, NaN when missing.
  void add(std::span<const Eigen::Vector3d> positions_m);
  // Refuses (our bug) when not as many frames as stated have been added.
  void finish();

 private:
  void write_header(const Take& take);
  void flush();

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::string buffer_;
  double rate_hz_;
  std::uint64_t stated_frames_, frames_ = 0;
  std::size_t markers_;
};

}  // namespace trilat
