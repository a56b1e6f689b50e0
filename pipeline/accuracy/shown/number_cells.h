// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string>

#include "datasets/results/summary.h"
#include "datasets/results/table.h"

namespace trilat {

// The measures along the world's axes.
inline constexpr std::array kAxisNames{"x", "y", "z"};

// A number in the unit that tables print: cm, degrees, %, m/s3 or steps. NaN where there is none.
TableValue shown_number(const Numbers& numbers, const NumberKey& key, int decimals);

// Columns of a table whose rows are the keys that their numbers share: the cell shows the number with the
// row's keys and these.
inline auto value_of(const Numbers& numbers, NumberKey more, int decimals = 2) {
  return CellOf{[&numbers, more = std::move(more), decimals](const NumberKey& row) {
                  return TableValue::of(*shown_number(numbers, row.with(more), decimals).number, decimals);
                },
                false, false};
}
inline auto interval_of(const Numbers& numbers, NumberKey more, int decimals = 2) {
  return CellOf{[&numbers, more = std::move(more), decimals](const NumberKey& row) {
                  return shown_number(numbers, row.with(more), decimals);
                },
                false, true};
}
inline auto count_of(const Numbers& numbers, NumberKey more) {
  return CellOf{[&numbers, more = std::move(more)](const NumberKey& row) {
                  return count_cell(numbers.n(row.with(more)));
                },
                false, false};
}

}  // namespace trilat
