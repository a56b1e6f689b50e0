// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "datasets/results/table.h"

namespace trilat {

// A cell with its interval, and + or - for good and bad, * and ~ for the best and its like.
inline std::string text_of(const TableValue& value) {
  std::string text = value.text;
  if (value.number)
    text = std::isnan(*value.number) ? "-"
           : value.decimals < 0      ? fmt::format("{:g}", *value.number)
                                     : fmt::format("{:.{}f}", *value.number, value.decimals);
  if (!std::isnan(value.low))
    text += fmt::format(" ({:.{}f} to {:.{}f})", value.low, value.decimals, value.high, value.decimals);
  constexpr std::array kSigns{"", "*", "~", "+", "-"};
  return text + kSigns.at(static_cast<std::size_t>(value.mark));
}

// The rows of a table, "cell | cell".
inline std::vector<std::string> rows_of(const Table& table) {
  std::vector<std::string> rows;
  for (const auto& row : table.rows) {
    std::string& text = rows.emplace_back();
    for (const TableValue& value : row) text += (&value == row.data() ? "" : " | ") + text_of(value);
  }
  return rows;
}

}  // namespace trilat
