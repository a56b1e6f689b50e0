// SPDX-License-Identifier: MIT
#include "datasets/mocap/row_cells.h"

#include <algorithm>
#include <limits>

#include "datasets/base/error.h"
#include "datasets/mocap/csv_cell.h"

namespace trilat {
namespace {

constexpr std::int64_t kHighestCount = 10'000;

}  // namespace

std::string_view RowCells::text() {
  ++column_;
  if (at_end_) {
    complete_ = false;
    return {};
  }
  const char* const end = line_.data() + line_.size();
  const auto size = static_cast<std::size_t>(end_of_cell(line_.data(), end) - line_.data());
  const std::string_view cell = line_.substr(0, size);
  at_end_ = size == line_.size();
  line_.remove_prefix(at_end_ ? size : size + 1);
  return cell;
}

void RowCells::skip(std::int64_t count) {
  for (std::int64_t i = 0; i < count && complete_; ++i) text();
}

std::int64_t RowCells::integer(const char* what) {
  const std::string_view cell = text();
  std::int64_t value = 0;
  if (complete_ && !parse_integer(cell, value)) refuse(cell, what);
  return value;
}

std::int64_t RowCells::count(const char* what) {
  const std::int64_t value = integer(what);
  if (value < 0 || value > kHighestCount) refuse(std::to_string(value), what);
  return value;
}

double RowCells::number(const char* what) {
  const std::string_view cell = text();
  double value = 0.0;
  const CellKind kind = parse_cell(cell, value);
  if (kind == CellKind::unreadable) refuse(cell, what);
  return kind == CellKind::number ? value : std::numeric_limits<double>::quiet_NaN();
}

Eigen::Vector3d RowCells::position(const char* what) {
  Eigen::Vector3d result;
  for (double& component : result) component = number(what);
  return result;
}

std::size_t RowCells::left() const {
  return at_end_ ? 0 : 1 + static_cast<std::size_t>(std::ranges::count(line_, ','));
}

void RowCells::refuse(std::string_view cell, const char* what) const {
  throw InputError(place_, "column " + std::to_string(column_) + ": \"" + std::string(cell.substr(0, 40)) +
                               "\" is no " + what);
}

}  // namespace trilat
