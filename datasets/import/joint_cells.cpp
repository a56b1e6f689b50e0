// SPDX-License-Identifier: MIT
#include "datasets/import/joint_cells.h"

#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/import/import_types.h"
#include "datasets/mocap/csv_cell.h"

namespace trilat {
namespace {

constexpr float kFarthestJoint_m = 20.0f;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// What a cell shows in a message: the beginning, and only what a terminal can take.
std::string shown(std::string_view cell) {
  std::string text(cell.substr(0, 24));
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';
  return text;
}

template <class T>
T exact_integer(std::string_view cell, std::string_view what) {
  T value = 0;
  cell = trimmed(cell);
  const auto [rest, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || rest != cell.data() + cell.size())
    throw TornRow{fmt::format("has \"{}\" where {} should be", shown(cell), what)};
  return value;
}

}  // namespace

std::vector<std::string_view> comma_cells(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const auto comma = line.find(',');
    cells.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) break;
    line.remove_prefix(comma + 1);
  }
  if (cells.back().empty()) cells.pop_back();
  return cells;
}

std::vector<std::string_view> blank_cells(std::string_view line) {
  std::vector<std::string_view> cells;
  std::size_t begin = 0;
  while (begin < line.size()) {
    std::size_t end = begin;
    while (end < line.size() && !is_blank(line[end])) ++end;
    if (end > begin) cells.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return cells;
}

double number_in(std::string_view cell, std::string_view what) {
  double value = 0.0;
  if (parse_cell(cell, value) != CellKind::number)
    throw TornRow{fmt::format("has \"{}\" where {} should be", shown(cell), what)};
  return value;
}

std::int64_t integer_in(std::string_view cell, std::string_view what) {
  return exact_integer<std::int64_t>(cell, what);
}

std::uint64_t id_in(std::string_view cell, std::string_view what) {
  return exact_integer<std::uint64_t>(cell, what);
}

std::uint8_t small_number_in(std::string_view cell, std::string_view what, int limit) {
  const auto value = exact_integer<std::int64_t>(cell, what);
  if (value < 0 || value > limit)
    throw TornRow{fmt::format("has {} as {}, which goes from 0 to {}", value, what, limit)};
  return static_cast<std::uint8_t>(value);
}

std::uint8_t tracking_state_of(double value, const std::string& place) {
  if (value != std::floor(value))
    throw InputError(place,
                     fmt::format("has the tracking state {}; states are 0, 1 or 2, so the file has been "
                                 "averaged or interpolated. Import it as it was recorded",
                                 value));
  if (value < 0.0 || value > 2.0)
    throw TornRow{fmt::format("has the tracking state {}, which goes from 0 to 2", value)};
  return static_cast<std::uint8_t>(value);
}

void check_positions(const Body& body, const std::string& place) {
  for (const auto& point : body.position_m)
    for (const float x : point)
      if (!(std::abs(x) <= kFarthestJoint_m))
        throw InputError(place,
                         fmt::format("has a joint at {:g} m, farther than any Kinect sees; positions must be "
                                     "in metres, not in millimetres or pixels",
                                     x));
}

}  // namespace trilat
