// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/import/body_file_reader.h"
#include "datasets/mocap/line_reader.h"

namespace trilat {

// A .skeleton file of the NTU RGB+D data sets: the number of frames; then of each frame the number of bodies,
// and of each body a line about it, the number of joints and a line a joint. Times are frame number / rate.
class NtuReader : public BodyFileReader {
 public:
  NtuReader(const std::filesystem::path& path, double rate_hz);
  bool next(FileFrame& frame) override;
  std::string place() const override { return lines_.place(); }
  std::uint64_t bytes_read() const override { return bytes_; }

 private:
  bool next_line(std::string_view& line);
  std::int64_t count_line(std::string_view what, std::int64_t limit);
  void read_body(FileFrame& frame, std::string& problem);

  LineReader lines_;
  double rate_hz_;
  std::uint64_t bytes_ = 0;
  std::int64_t frames_ = 0;
  std::int64_t frame_ = 0;
};

// What the name S001C002P003R002A013.skeleton says.
struct NtuName {
  std::string camera;     // C002
  std::string recording;  // all but the camera
};
std::optional<NtuName> ntu_name_of(const std::filesystem::path& path);

}  // namespace trilat
