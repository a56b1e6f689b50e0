// SPDX-License-Identifier: MIT
#include "datasets/mocap/header_keys.h"

#include <cmath>

#include "datasets/base/error.h"
#include "datasets/mocap/csv_cell.h"
#include "datasets/mocap/line_reader.h"
#include "datasets/mocap/mocap_take.h"

namespace trilat {

std::string HeaderKeys::text(std::string_view key) const {
  const auto found = values_.find(key);
  return found == values_.end() ? std::string() : found->second;
}

std::optional<std::int64_t> HeaderKeys::count(std::string_view key) const {
  const std::string cell = text(key);
  std::int64_t value = 0;
  if (cell.empty()) return std::nullopt;
  if (!parse_integer(cell, value)) refuse(key, "an integer");
  return value;
}

std::int64_t HeaderKeys::stated_count(std::string_view key, std::int64_t most) const {
  const auto value = count(key);
  if (!value || *value < 0 || *value > most) refuse(key, "an integer from 0 to " + std::to_string(most));
  return *value;
}

double HeaderKeys::rate_hz(std::string_view key) const {
  const std::string cell = text(key);
  double value = kMissing;
  if (cell.empty()) return value;
  if (parse_cell(cell, value) != CellKind::number || !is_frame_rate(value))
    refuse(key, "a rate of 1 to 9000 Hz, such as 120.000000");
  return value;
}

double HeaderKeys::stated_rate_hz(std::string_view key) const {
  const double value = rate_hz(key);
  if (std::isnan(value)) refuse(key, "a rate of 1 to 9000 Hz, such as 120.000000");
  return value;
}

LengthUnit HeaderKeys::length_unit(std::string_view key) const {
  const auto unit = length_unit_from_text(text(key));
  if (!unit) refuse(key, "Meters, Centimeters, Millimeters, Inches or Feet");
  return *unit;
}

void HeaderKeys::refuse(std::string_view key, const std::string& right) const {
  const std::string cell = text(key);
  throw InputError(place_, "\"" + std::string(key) + "\" is " +
                               (cell.empty() ? "not stated" : "\"" + cell + "\"") + "; it must be " + right);
}

}  // namespace trilat
