// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "datasets/base/text_output.h"
#include "datasets/mocap/mocap_take.h"

namespace trilat {

// Writes the positions of a take as Motive 1.25 lays it out: in the header's unit with six decimals; what is
// missing is an empty cell. Streams beside the final name and takes it only in finish(); without that the
// partial file is removed.
class OptitrackCsvWriter {
 public:
  // Uses of `header` the names, rates, counts, length unit and assets. Rates must be stated.
  // OutputError when the file cannot be written.
  OptitrackCsvWriter(const std::filesystem::path& path, MocapHeader header);

  // One pose for each asset of the header. The printed time is index / export rate.
  void write(const MocapFrame& frame);
  // The number of frames must be the one the header states, when it states one.
  void finish();

 private:
  void write_header();

  TextOutput file_;
  MocapHeader header_;
  double per_metre_;
  std::string row_;
  std::int64_t frames_ = 0;
};

}  // namespace trilat
