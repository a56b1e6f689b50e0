// SPDX-License-Identifier: MIT
#include "datasets/mocap/marker_header.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "datasets/base/error.h"
#include "datasets/mocap/csv_cell.h"
#include "datasets/mocap/header_keys.h"

namespace trilat {
namespace {

using Cells = std::vector<std::string>;

constexpr std::int64_t kMostMarkers = 100'000;
constexpr std::size_t kMostHeaderLines = 10'000;  // events have a line each

// Without the empty cells behind the last one.
Cells tab_cells(std::string_view line) {
  Cells cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find('\t', begin), line.size());
    std::string_view cell = line.substr(begin, end - begin);
    while (cell.ends_with(' ')) cell.remove_suffix(1);
    while (cell.starts_with(' ')) cell.remove_prefix(1);
    cells.emplace_back(cell);
    begin = end + 1;
  }
  while (!cells.empty() && cells.back().empty()) cells.pop_back();
  return cells;
}

Cells next_cells(LineReader& lines, const char* what) {
  std::string_view line;
  if (!lines.next(line)) throw InputError(lines.place(), std::string("the file ends before ") + what);
  return tab_cells(line);
}

// Three columns a marker from `first` on.
void add_markers(const Cells& names, std::size_t first, ColumnHeader& result) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string number = std::to_string(i + 1);
    result.header.assets.push_back({.type = AssetType::marker,
                                    .name = names[i].empty() ? "marker " + number : names[i],
                                    .id = number,
                                    .parent = {},
                                    .has_rotation = false,
                                    .has_position = true});
    AssetColumns& columns = result.layout.columns.emplace_back();
    columns.fill(kNoColumn);
    for (std::size_t axis = 0; axis < 3; ++axis) columns[4 + axis] = first + 3 * i + axis;
  }
  result.layout.used_columns = first + 3 * names.size();
  result.layout.written_columns = result.layout.used_columns + 1;  // a tab may end a row
  result.layout.tab_separated = true;
}

// Every third cell of "Frame#, Time, a, , , b, , ".
Cells trc_names(const Cells& labels, std::size_t markers, const std::string& place) {
  if (labels.size() < 2 || !labels[0].starts_with("Frame") || labels[1] != "Time")
    throw InputError(place, "is not the row \"Frame#, Time\" and the markers' names, with tabs between");
  Cells names(markers);
  for (std::size_t column = 2; column < labels.size(); ++column) {
    if (labels[column].empty()) continue;
    const std::size_t marker = (column - 2) / 3;
    if ((column - 2) % 3 != 0 || marker >= markers)
      throw InputError(place, "column " + std::to_string(column + 1) + " has \"" + labels[column] +
                                  "\"; NumMarkers says " + std::to_string(markers) +
                                  " names, one above each X");
    names[marker] = labels[column];
  }
  return names;
}

bool is_qualisys_key(std::string_view cell) {
  for (std::string_view word : {"FREQUENCY", "DESCRIPTION", "EVENT"})
    if (cell == word) return true;
  const auto is_key_letter = [](char c) {
    return c == '_' || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  };
  return cell.find('_') != std::string_view::npos && std::ranges::all_of(cell, is_key_letter);
}

// "Frame", "Time", "a X", …, where the export has headings.
bool is_heading_row(const Cells& cells) {
  double ignored = 0.0;
  return !cells.empty() && parse_cell(cells[0], ignored) == CellKind::unreadable;
}

struct QualisysKeys {
  HeaderValues values;
  Cells names;
};

// Leaves `lines` before the first row of data, of which it gives the number of cells in `width`.
QualisysKeys read_qualisys_keys(LineReader& lines, std::string_view line, std::size_t& width) {
  QualisysKeys keys;
  for (std::size_t count = 0; count < kMostHeaderLines; ++count) {
    const Cells cells = tab_cells(line);
    if (cells.empty() ? !line.empty() : !is_qualisys_key(cells[0]) && !is_heading_row(cells)) {
      width = static_cast<std::size_t>(std::ranges::count(line, '\t')) + 1;
      lines.unread();
      return keys;
    }
    if (!cells.empty() && cells[0] == "MARKER_NAMES") keys.names.assign(cells.begin() + 1, cells.end());
    if (cells.size() > 1 && is_qualisys_key(cells[0])) keys.values.emplace(cells[0], cells[1]);
    if (!lines.next(line)) return keys;
  }
  throw InputError(lines.place(), "no row of numbers follows the header");
}

}  // namespace

bool is_trc(std::string_view first_line) { return first_line.starts_with("PathFileType"); }

ColumnHeader read_trc_header(LineReader& lines, std::string_view first_line) {
  const Cells first = tab_cells(first_line);
  if (first.size() < 3 || first[2] != "(X/Y/Z)")
    throw InputError(lines.place(), "the third cell is not (X/Y/Z), the order of the columns of a marker");
  const Cells keys = next_cells(lines, "the keys of the header");
  const Cells cells = next_cells(lines, "the values of the header");
  HeaderValues values;
  for (std::size_t i = 0; i < std::min(keys.size(), cells.size()); ++i) values.emplace(keys[i], cells[i]);
  const HeaderKeys header(std::move(values), lines.place());
  ColumnHeader result;
  result.header.format = "TRC";
  if (first.size() > 3) result.header.take_name = first[3];
  result.header.export_rate_hz = header.stated_rate_hz("DataRate");
  result.header.total_exported_frames = header.stated_count("NumFrames", kHighestFrame);
  result.header.length_unit = header.length_unit("Units");
  const auto markers = static_cast<std::size_t>(header.stated_count("NumMarkers", kMostMarkers));
  const Cells labels = next_cells(lines, "the row of names");
  add_markers(trc_names(labels, markers, lines.place()), 2, result);
  const Cells axes = next_cells(lines, "the row of axes");
  if (markers > 0 && (axes.size() < 3 || axes[2] != "X1"))
    throw InputError(lines.place(), "is not the row of axes \"X1, Y1, Z1\", of which X1 is the third cell");
  return result;
}

bool is_qualisys(std::string_view first_line) {
  return first_line.starts_with("NO_OF_") || first_line.starts_with("FILE_VERSION");
}

ColumnHeader read_qualisys_header(LineReader& lines, std::string_view first_line) {
  const std::string place = lines.place();
  std::size_t width = 0;
  QualisysKeys keys = read_qualisys_keys(lines, first_line, width);
  const HeaderKeys header(std::move(keys.values), place);
  const std::string included = header.text("DATA_INCLUDED");
  if (included != "3D")
    throw InputError(place, "DATA_INCLUDED is \"" + included + "\"; it must be 3D, the markers' positions");
  const auto markers = static_cast<std::size_t>(header.stated_count("NO_OF_MARKERS", kMostMarkers));
  if (keys.names.size() != markers)
    throw InputError(place, "NO_OF_MARKERS is " + std::to_string(markers) + ", but MARKER_NAMES has " +
                                std::to_string(keys.names.size()) + " names");
  ColumnHeader result;
  result.header.format = "Qualisys TSV";
  result.header.capture_start_text = header.text("TIME_STAMP");
  result.header.export_rate_hz = header.stated_rate_hz("FREQUENCY");
  result.header.total_exported_frames = header.stated_count("NO_OF_FRAMES", kHighestFrame);
  result.header.length_unit = LengthUnit::millimetre;
  // One more cell is only the tab that ends the row.
  result.layout.has_frame_and_time = width >= 3 * markers + 2;
  add_markers(keys.names, 2, result);
  return result;
}

}  // namespace trilat
