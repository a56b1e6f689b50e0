// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "datasets/mocap/column_header.h"
#include "datasets/mocap/line_reader.h"

namespace trilat {

// Data rows of the formats with a frame a row and a number a column: Motive and TRC. Time is the frame index
// times the export rate; only when the header states no rate it is the printed one.
class ColumnRows {
 public:
  // Reads ahead to the first row and completes `header` with its frame index. Both `lines` and `header` must
  // outlive the rows.
  ColumnRows(LineReader& lines, MocapHeader& header, ColumnLayout layout);
  void read_only(const std::vector<std::size_t>& assets);
  // Time strictly advances from frame to frame; rows that do not advance are dropped and counted.
  bool next(MocapFrame& frame, MocapAnomalies& anomalies);

 private:
  // The next row that is not blank, with commas between its cells, a frame number and a time.
  bool next_row(std::string_view& line);
  std::string_view with_commas(std::string_view line);
  void check_promise(MocapAnomalies& anomalies) const;
  void check_order() const;
  void check_times(const MocapAnomalies& anomalies) const;
  void check_decimal_comma(std::string_view line) const;
  bool read_row(std::string_view line, MocapFrame& frame, MocapAnomalies& anomalies);
  std::int64_t read_index(std::string_view line) const;
  const char* read_cells(const char* p, const char* end, std::size_t& fields);
  const char* read_number(const char* p, const char* end, std::size_t column);
  bool set_time(MocapFrame& frame, MocapAnomalies& anomalies);
  void set_pose(std::size_t number, MocapPose& pose, MocapAnomalies& anomalies);
  [[noreturn]] void refuse_cell(std::size_t column, std::string_view cell, const char* problem) const;
  InputError cell_refusal(std::size_t column, std::string_view cell, const char* problem) const;

  LineReader& lines_;
  const MocapHeader& header_;
  ColumnLayout layout_;
  std::vector<std::size_t> assets_;
  std::vector<std::size_t> target_;  // of each column in numbers_; kNoColumn to skip it
  std::vector<double> numbers_;      // of one row: kSlotsPerAsset an asset, and the printed time
  std::int64_t not_finite_cells_ = 0;
  double metres_ = 1.0;
  std::int64_t rate_uhz_ = 0;  // 0: not stated
  std::string text_;           // of a row that had tabs
  std::int64_t rows_ = 0;      // read so far
  bool started_ = false;
  std::int64_t last_index_ = 0;
  std::int64_t first_index_ = 0, previous_index_ = 0;  // of the first row, and of the row before
  std::int64_t steps_back_ = 0;                        // rows whose frame is before that of the row before
  double first_printed_s_ = kMissing;
  double last_printed_s_ = kMissing;
  FarNumbers far_;
};

}  // namespace trilat
