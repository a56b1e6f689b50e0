// SPDX-License-Identifier: MIT
#include "datasets/mocap/motive_header.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "datasets/base/error.h"
#include "datasets/mocap/csv_cell.h"
#include "datasets/mocap/motive_columns.h"
#include "datasets/mocap/row_source.h"

namespace trilat {
namespace {

using Cells = std::vector<std::string>;

constexpr std::size_t kMostHeaderRows = 64;
constexpr double kLowestRate_hz = 1.0;
constexpr double kHighestRate_hz = 9000.0;
constexpr std::array<std::string_view, 12> kKeys{
    "Format Version",        "Take Name",          "Take Notes",          "Capture Frame Rate",
    "Export Frame Rate",     "Capture Start Time", "Capture Start Frame", "Total Frames in Take",
    "Total Exported Frames", "Rotation Type",      "Length Units",        "Coordinate Space"};

bool is_blank(const Cells& cells) {
  return std::ranges::all_of(cells, [](const std::string& cell) { return cell.empty(); });
}

bool is_axis_row(const Cells& cells) {
  return cells.size() >= 2 && cells[0] == "Frame" && cells[1].starts_with("Time");
}

// Free text may hold commas and runs to the next key; any other value is one cell.
std::map<std::string, std::string, std::less<>> read_keys(const Cells& cells) {
  const auto is_key = [](const std::string& cell) { return std::ranges::find(kKeys, cell) != kKeys.end(); };
  std::map<std::string, std::string, std::less<>> values;
  for (std::size_t i = 0; i + 1 < cells.size(); ++i) {
    if (!is_key(cells[i])) continue;
    const std::string& key = cells[i];
    std::string value = cells[++i];
    if (key == "Take Name" || key == "Take Notes")
      while (i + 1 < cells.size() && !is_key(cells[i + 1])) value += "," + cells[++i];
    value.erase(value.find_last_not_of(',') + 1);
    values.emplace(key, value);
  }
  return values;
}

class KeyReader {
 public:
  KeyReader(std::map<std::string, std::string, std::less<>> values, std::string place)
      : values_(std::move(values)), place_(std::move(place)) {}

  std::string text(std::string_view key) const {
    const auto found = values_.find(key);
    return found == values_.end() ? std::string() : found->second;
  }
  std::optional<std::int64_t> count(std::string_view key) const {
    const std::string cell = text(key);
    std::int64_t value = 0;
    if (cell.empty()) return std::nullopt;
    if (!parse_integer(cell, value)) refuse(key, cell, "an integer");
    return value;
  }
  double rate_hz(std::string_view key) const {
    const std::string cell = text(key);
    double value = kMissing;
    if (cell.empty()) return value;
    if (parse_cell(cell, value) != CellKind::number || !(value >= kLowestRate_hz && value <= kHighestRate_hz))
      refuse(key, cell, "a rate of 1 to 9000 Hz, such as 120.000000");
    return value;
  }
  LengthUnit length_unit() const {
    const std::string cell = text("Length Units");
    const auto unit = length_unit_from_text(cell);
    if (!unit) refuse("Length Units", cell, "Meters, Centimeters, Millimeters, Inches or Feet");
    return *unit;
  }

 private:
  [[noreturn]] void refuse(std::string_view key, const std::string& cell, const std::string& right) const {
    throw InputError(place_, "\"" + std::string(key) + "\" is " +
                                 (cell.empty() ? "not stated" : "\"" + cell + "\"") + "; it must be " +
                                 right);
  }

  std::map<std::string, std::string, std::less<>> values_;
  std::string place_;
};

MocapHeader header_from(const KeyReader& keys) {
  MocapHeader header;
  header.format = "Motive CSV " + keys.text("Format Version");
  header.take_name = keys.text("Take Name");
  header.take_notes = keys.text("Take Notes");
  header.capture_start_text = keys.text("Capture Start Time");
  header.capture_rate_hz = keys.rate_hz("Capture Frame Rate");
  header.export_rate_hz = keys.rate_hz("Export Frame Rate");
  if (std::isnan(header.export_rate_hz)) header.export_rate_hz = header.capture_rate_hz;
  header.capture_start_frame = keys.count("Capture Start Frame");
  header.total_frames_in_take = keys.count("Total Frames in Take");
  header.total_exported_frames = keys.count("Total Exported Frames");
  header.length_unit = keys.length_unit();
  const std::string rotation = keys.text("Rotation Type");
  if (!rotation.empty()) header.rotation_type = rotation;
  const std::string space = keys.text("Coordinate Space");
  if (!space.empty()) header.coordinate_space = space;
  return header;
}

}  // namespace

MotiveHeader read_motive_header(LineReader& lines, std::string_view first_line) {
  const std::string first_place = lines.place();
  Cells keys = split_csv(first_line);
  std::vector<Cells> rows;
  bool keys_ended = false;
  std::string_view line;
  for (std::size_t count = 1; lines.next(line); ++count) {
    Cells cells = split_csv(line);
    if (is_axis_row(cells)) {
      MotiveHeader result;
      result.header = header_from(KeyReader(read_keys(keys), first_place));
      result.layout = read_motive_columns(rows, cells, lines.place(), result.header);
      return result;
    }
    if (count >= kMostHeaderRows) break;
    if (is_blank(cells)) {
      keys_ended = true;
    } else if (keys_ended || cells.front().empty()) {
      rows.push_back(std::move(cells));
    } else {
      keys.insert(keys.end(), cells.begin(), cells.end());
    }
  }
  throw InputError(
      first_place,
      "no row starting with \"Frame,Time\" follows; export again from Motive with the header switched on");
}

}  // namespace trilat
