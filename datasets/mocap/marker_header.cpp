// SPDX-License-Identifier: MIT
#include "datasets/mocap/marker_header.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "datasets/base/error.h"
#include "datasets/mocap/header_keys.h"

namespace trilat {
namespace {

using Cells = std::vector<std::string>;

constexpr std::int64_t kMostMarkers = 100'000;

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

}  // namespace trilat
