// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "datasets/base/units.h"
#include "datasets/results/summary.h"
#include "reports/tables/table.h"

namespace trilat {

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
