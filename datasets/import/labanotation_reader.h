// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/import/body_file_reader.h"
#include "datasets/mocap/line_reader.h"

namespace trilat {

// The body CSV of Microsoft's LabanotationSuite: no header; a row is the time in ticks of 100 ns and for each
// of the 25 joints x, y, z in metres and the tracking state. One body.
class LabanotationReader : public BodyFileReader {
 public:
  explicit LabanotationReader(const std::filesystem::path& path);
  bool next(FileFrame& frame) override;
  std::string place() const override { return lines_.place(); }
  std::uint64_t bytes_read() const override { return bytes_; }

 private:
  LineReader lines_;
  std::uint64_t bytes_ = 0;
};

}  // namespace trilat
