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
  std::filesystem::path position, time, orientation;  // orientation may be empty
};
// Those of a folder. InputError when there is not exactly one of each, no orientation apart.
KimoreFiles kimore_files_of(const std::filesystem::path& folder);

class KimoreReader : public BodyFileReader {
 public:
  explicit KimoreReader(const KimoreFiles& files);
  bool next(FileFrame& frame) override;
  std::string place() const override { return positions_.place(); }
  std::uint64_t bytes_read() const override { return bytes_; }

 private:
  bool next_row(LineReader& lines, std::string_view& line);

  LineReader positions_, times_;
  std::unique_ptr<LineReader> orientations_;
  std::uint64_t bytes_ = 0;
};

}  // namespace trilat
