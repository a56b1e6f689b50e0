// SPDX-License-Identifier: MIT
#include "datasets/mocap/csv_cell.h"

#include <charconv>
#include <cmath>

#include "datasets/base/error.h"
#include "datasets/base/text_output.h"
#include "datasets/mocap/line_reader.h"
#include "datasets/mocap/mocap_take.h"

namespace trilat {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string_view bare(std::string_view text) {
  text = trimmed(text);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
    text = trimmed(text.substr(1, text.size() - 2));
  return text;
}

// Old C libraries print what is not a number as 1.#IND0000, 1.#QNAN, 1.#INF; some drop the "1.".
bool spells_not_a_number(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  if (text.starts_with("1.#")) text.remove_prefix(2);
  for (std::string_view word : {"#IND", "#QNAN", "#SNAN", "#INF"})
    if (text.starts_with(word)) return true;
  return false;
}

}  // namespace

std::vector<std::string> split_csv(std::string_view line) {
  std::vector<std::string> cells = csv_fields(line);
  for (std::string& cell : cells) cell = trimmed(cell);
  return cells;
}

CellKind parse_cell(std::string_view text, double& value) {
  text = bare(text);
  if (text.empty()) return CellKind::empty;
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && rest == text.data() + text.size())
    return std::isfinite(value) ? CellKind::number : CellKind::not_finite;
  return spells_not_a_number(text) ? CellKind::not_finite : CellKind::unreadable;
}

bool parse_integer(std::string_view text, std::int64_t& value) {
  text = bare(text);
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && rest == text.data() + text.size();
}

const char* end_of_cell(const char* p, const char* end) {
  bool quoted = false;
  for (; p != end; ++p) {
    if (*p == '"') quoted = !quoted;
    if (*p == ',' && !quoted) return p;
  }
  return end;
}

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
