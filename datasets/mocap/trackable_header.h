// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "datasets/mocap/line_reader.h"
#include "datasets/mocap/mocap_take.h"

namespace trilat {

// The first cell of a row, which says what the row is.
std::string_view row_type(std::string_view line);
// "trackable" or "rigidbody": before the first frame it defines a body, behind a frame row it tells more
// about one.
bool is_body_row(std::string_view line);
// One of the row types of Arena, Tracking Tools and early Motive ("1.0", "1.1").
bool is_known_row(std::string_view line);
[[noreturn]] void refuse_row(std::string_view line, const std::string& place);

struct TrackableBody {
  std::int64_t id = 0;
  std::int64_t marker_count = 0;
  std::size_t asset = 0;
  std::size_t first_solved = 0;  // asset of its first rigid body marker
  std::size_t first_marker = 0;  // asset of its first measured marker
};

struct TrackableHeader {
  MocapHeader header;
  std::vector<TrackableBody> bodies;
  std::size_t cells_per_solved_marker = 3;   // version 1.1 adds its ID
  std::size_t cells_per_visible_marker = 4;  // version 1.1 adds its name
  std::string first_frame_line;              // read ahead; empty when there is none
};

// Reads the rows before the first frame, `first_line` being read already, and that frame, whose line is then
// the last one read. InputError when there is neither a frame nor a body. Markers are among the assets when
// extended rows follow the frame.
TrackableHeader read_trackable_header(LineReader& lines, std::string_view first_line);

// Walks the cells of one row of which every cell has its meaning from its position. A row that ends too early
// makes complete() false and yields zeros; a cell that is not what it has to be is an InputError at `place`,
// naming the column.
class RowCells {
 public:
  RowCells(std::string_view line, std::string place) : line_(line), place_(std::move(place)) {}

  std::string_view text();
  void skip(std::int64_t count);
  std::int64_t integer(const char* what);
  std::int64_t count(const char* what);        // 0 to 10000
  double number(const char* what);             // NaN when missing
  Eigen::Vector3d position(const char* what);  // three cells, as written
  bool complete() const { return complete_; }
  std::size_t left() const;

 private:
  [[noreturn]] void refuse(std::string_view cell, const char* what) const;

  std::string_view line_;
  std::string place_;
  std::int64_t column_ = 0;
  bool at_end_ = false;
  bool complete_ = true;
};

}  // namespace trilat
