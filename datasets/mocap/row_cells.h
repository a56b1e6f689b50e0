// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace trilat {

// Walks the cells of one row of which every cell has its meaning from its position. A row that
// ends too early makes complete() false and yields zeros; a cell that is not what it has to be is
// an InputError at `place`, naming the column.
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
