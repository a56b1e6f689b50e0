// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>

#include "datasets/import/body_file_reader.h"
#include "datasets/mocap/line_reader.h"

namespace trilat {

// The files of one exercise of the KIMORE data set, row beside row: JointPosition*.csv (x, y, z and tracking
// state of 25 joints), TimeStamp*.csv (ticks of 100 ns) and, when there is one, JointOrientation*.csv.
struct KimoreFiles {
  std::filesystem::path position, time, orientation;  // time and orientation may be empty
};
// Those of a folder, or the positions alone. InputError when a folder has not one file of positions, or
// several of one kind.
KimoreFiles kimore_files_of(const std::filesystem::path& path);

class KimoreReader : public BodyFileReader {
 public:
  // `rate_hz`: of the rows, where they have no time stamps.
  KimoreReader(const KimoreFiles& files, double rate_hz);
  bool next(FileFrame& frame) override;
  std::string place() const override { return positions_.place(); }
  std::uint64_t bytes_read() const override { return bytes_; }

 private:
  bool next_row(LineReader& lines, std::string_view& line);

  LineReader positions_;
  std::unique_ptr<LineReader> times_, orientations_;
  double rate_hz_;
  std::int64_t rows_ = 0;
  std::uint64_t bytes_ = 0;
};

}  // namespace trilat
