// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/units.h"
#include "datasets/results/summary.h"

namespace trilat {

// One cell: a number with the decimals it is printed with (negative: as many as it needs, up to six
// digits), or a text. CSV gets the number unrounded.
struct TableValue {
  std::optional<double> number;
  int decimals = 1;
  std::string text;

  static TableValue of(double value, int decimals) { return {value, decimals, {}}; }
  static TableValue of(std::string text) { return {std::nullopt, 0, std::move(text)}; }
};

struct TableColumn {
  std::string name;  // with its unit, as in "MAE (cm)"
  std::string key;   // lower_snake with unit, for CSV
  bool is_text = false;
  bool is_key = false;  // a number that was chosen, not measured: it may name the row
};

// The name with its unit: that of the key where the name has none, as for the ends of an interval.
std::string header_of(const TableColumn& column);

// Letters, digits, '.', '_' and '-' stay, anything else becomes '-'.
std::string usable_id(std::string text);

// A table as data; renderings are made from it and never compute.
struct Table {
  std::string id;     // usable_id(): a file name and a LaTeX label
  std::string title;  // what was measured on what, with every setting that changes a number; says "simulated"
  std::vector<TableColumn> columns;
  std::vector<std::vector<TableValue>> rows;
  std::vector<std::string> notes;  // one sentence each
};

// Cells of tables: SI values in, printed units out. NaN stays NaN, which prints as a dash.
inline TableValue cm_cell(double metres) { return TableValue::of(metres * kCentimetresPerMetre, 2); }
inline TableValue mm_cell(double metres) { return TableValue::of(metres / kMetresPerMillimetre, 2); }
inline TableValue degree_cell(double radians) { return TableValue::of(radians * kDegreesPerRad, 2); }
inline TableValue percent_cell(double share) { return TableValue::of(100.0 * share, 1); }
inline TableValue count_cell(std::uint64_t n) { return TableValue::of(static_cast<double>(n), 0); }
inline TableValue no_cell() { return TableValue::of(kNoNumber, 0); }

inline double share_of(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? kNoNumber : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace trilat
