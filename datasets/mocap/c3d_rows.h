// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/byte_file.h"
#include "datasets/markers/c3d_parameters.h"
#include "datasets/mocap/line_reader.h"

namespace trilat {

// Whether the file begins like a C3D file.
bool is_c3d(const std::filesystem::path& path);

// The points of a C3D file: real or scaled integer, of any processor. A point with a negative residual is
// missing; analog samples are stepped over. Time is the frame's number over the rate of the points.
class C3dRows : public RowSource {
 public:
  // Fills `header`, which must outlive the rows. InputError when the file holds no points, does not say their
  // unit or rate, or is shorter than its header says.
  C3dRows(const std::filesystem::path& path, MocapHeader& header);
  void read_only(const std::vector<std::size_t>& assets) override { assets_ = assets; }
  bool next(MocapFrame& frame, MocapAnomalies& anomalies) override;

 private:
  [[noreturn]] void refuse(const std::string& problem) const;
  double word(std::size_t number) const;
  std::uint64_t count(const char* name, std::size_t header_word) const;
  void read_unit_and_rate();
  void read_frame_range();
  void name_points();
  void check_size() const;
  MocapPose read_point(std::size_t point, MocapAnomalies& anomalies) const;

  ByteFile file_;
  MocapHeader& header_;
  std::vector<std::byte> start_;  // the first block
  C3dParameters parameters_;
  std::vector<std::size_t> assets_;
  std::size_t points_ = 0;
  double scale_m_ = 0.0;          // of an integer
  std::size_t number_bytes_ = 4;  // 2: integers
  std::uint64_t data_start_ = 0;
  std::int64_t frames_ = 0;
  std::int64_t frame_ = 0;
  std::vector<std::byte> bytes_;  // of one frame
};

}  // namespace trilat
