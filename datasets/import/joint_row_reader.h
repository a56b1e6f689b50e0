// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "datasets/import/body_file_reader.h"
#include "datasets/mocap/line_reader.h"

namespace trilat {

// A text file without header whose row is the time and for each of the 25 joints x, y, z in metres, in the
// SDK's order, and in some formats the tracking state. Without states every joint is called tracked.
struct JointRowFormat {
  std::vector<std::string_view> (*cells_of)(std::string_view line);
  const char* time_unit;
  std::int64_t ticks_per_unit;
  bool has_states;
};

// The body CSV of Microsoft's LabanotationSuite.
extern const JointRowFormat kLabanotationRows;
// UMONS-TAICHI (Tits et al. 2018, doi 10.1016/j.dib.2018.05.088).
extern const JointRowFormat kUmonsTaichiRows;

// One body.
class JointRowReader : public BodyFileReader {
 public:
  JointRowReader(const std::filesystem::path& path, const JointRowFormat& format);
  bool next(FileFrame& frame) override;
  std::string place() const override { return lines_.place(); }
  std::uint64_t bytes_read() const override { return bytes_; }

 private:
  const JointRowFormat& format_;
  LineReader lines_;
  std::uint64_t bytes_ = 0;
};

}  // namespace trilat
