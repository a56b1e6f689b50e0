// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/mocap/column_header.h"

namespace trilat {
namespace {

using Cells = std::vector<std::string>;

constexpr std::int64_t kMaxMarkers = 100'000;
constexpr std::size_t kFirst = 2;  // column of the first marker: frame and time stand before it

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
  if (line.find('\t') == std::string_view::npos && line.find(',') != std::string_view::npos)
    throw InputError(lines.place(), "has commas between its cells; tabs must stand there");
  if (line.find('\t') == std::string_view::npos && line.find(' ') != std::string_view::npos)
    throw InputError(lines.place(), "has blanks between its cells; tabs must stand there");
  return tab_cells(line);
}

// Some programs put two tabs behind some of the values, so that they stand under other keys.
HeaderValues values_of(Cells keys, Cells values) {
  if (keys.size() != values.size()) {
    std::erase(keys, "");
    std::erase(values, "");
  }
  HeaderValues result;
  for (std::size_t i = 0; i < std::min(keys.size(), values.size()); ++i) result.emplace(keys[i], values[i]);
  return result;
}

// Every third cell of "Frame#, Time, a, , , b, , ".
Cells names_of(const Cells& labels, const std::string& place) {
  if (labels.size() < kFirst || !labels[0].starts_with("Frame") || !labels[1].starts_with("Time"))
    throw InputError(place, "is not the row \"Frame#, Time\" and the markers' names, with tabs between");
  Cells names;
  for (std::size_t column = kFirst; column < labels.size(); ++column) {
    const bool is_name = (column - kFirst) % 3 == 0;
    if (is_name) names.push_back(labels[column]);
    if (!is_name && !labels[column].empty())
      throw InputError(place, "column " + std::to_string(column + 1) + " has \"" + labels[column] +
                                  "\"; names stand above each X, with two empty cells between them");
  }
  return names;
}

// Three columns a marker.
void add_markers(const Cells& names, ColumnHeader& result) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string number = std::to_string(i + 1);
    result.header.assets.push_back({.type = AssetType::marker,
                                    .name = names[i].empty() ? "marker " + number : names[i],
                                    .id = number,
                                    .parent = {},
                                    .has_position = true});
    AssetColumns& columns = result.layout.columns.emplace_back();
    columns.fill(kNoColumn);
    for (std::size_t axis = 0; axis < 3; ++axis) columns[axis] = kFirst + 3 * i + axis;
  }
  result.layout.used_columns = kFirst + 3 * names.size();
  result.layout.written_columns = result.layout.used_columns + 1;  // a tab may end a row
  result.layout.tab_separated = true;
}

// The row below the names says nothing that they do not; a file may lack it.
void skip_axes(LineReader& lines) {
  std::string_view line;
  if (!lines.next(line)) throw InputError(lines.place(), "the file ends before its data");
  const std::size_t first = line.find_first_not_of(" \t");
  const bool is_row_of_data = first != std::string_view::npos && line[first] >= '0' && line[first] <= '9';
  if (is_row_of_data) lines.put_back();
}

struct TimedRow {
  std::int64_t frame;
  double time;  // in the file's unit
};

// The first rows of data, up to one whose frame does not advance.
std::vector<TimedRow> first_rows(const std::filesystem::path& path) {
  constexpr std::size_t kRows = 300, kBlockBytes = 1 << 20;
  LineReader lines(path, kBlockBytes);
  std::vector<TimedRow> rows;
  bool is_below_names = false;
  for (std::string_view line; rows.size() < kRows && lines.next(line);) {
    is_below_names |= line.starts_with("Frame");
    if (!is_below_names) continue;
    const Cells cells = tab_cells(line);
    TimedRow row{};
    if (cells.size() < kFirst || !parse_integer(cells[0], row.frame) ||
        parse_cell(cells[1], row.time) != CellKind::number)
      continue;
    if (!rows.empty() && row.frame <= rows.back().frame) break;
    rows.push_back(row);
  }
  return rows;
}

// Of the first of them, as many as have times that grow.
std::size_t count_advancing(const std::vector<TimedRow>& rows) {
  const auto end =
      std::ranges::adjacent_find(rows, [](const TimedRow& a, const TimedRow& b) { return a.time >= b.time; });
  return end == rows.end() ? rows.size() : static_cast<std::size_t>(end - rows.begin()) + 1;
}

}  // namespace

bool is_trc(std::string_view first_line) { return first_line.starts_with("PathFileType"); }

ColumnHeader read_trc_header(LineReader& lines, std::string_view first_line) {
  for (const char* order : {"(X/Z/Y)", "(Y/X/Z)", "(Y/Z/X)", "(Z/X/Y)", "(Z/Y/X)"})
    if (first_line.find(order) != std::string_view::npos)
      throw InputError(lines.place(), std::string("has the columns of a marker in the order ") + order +
                                          "; (X/Y/Z) is read");
  ColumnHeader result;
  const std::string_view behind = first_line.substr(std::min(first_line.rfind("(X/Y/Z)"), first_line.size()));
  if (const Cells cells = tab_cells(behind); cells.size() > 1) result.header.take_name = cells[1];
  Cells keys = next_cells(lines, "the keys of the header");
  Cells values = next_cells(lines, "the values of the header");
  const HeaderKeys header(values_of(std::move(keys), std::move(values)), lines.place());
  result.header.format = "TRC";
  double stated_hz = kNaN;
  const bool is_zero = parse_cell(header.text("DataRate"), stated_hz) == CellKind::number && stated_hz == 0.0;
  if (!is_zero) result.header.export_rate_hz = header.rate_hz("DataRate");
  result.header.total_exported_frames = header.stated_count("NumFrames", kHighestFrame);
  result.header.length_unit = header.length_unit("Units");
  const auto stated = static_cast<std::size_t>(header.stated_count("NumMarkers", kMaxMarkers));
  const Cells labels = next_cells(lines, "the row of names");
  Cells names = names_of(labels, lines.place());
  names.resize(std::max(names.size(), stated));  // the last ones may have no name
  add_markers(names, result);
  skip_axes(lines);
  return result;
}

void settle_trc_rate(const std::filesystem::path& path, ColumnHeader& columns) {
  MocapHeader& header = columns.header;
  const std::vector<TimedRow> rows = first_rows(path);
  const double stated_hz = header.export_rate_hz;
  const bool is_stated = std::isfinite(stated_hz);
  const std::size_t advancing = count_advancing(rows);
  if (advancing < 2) {
    if (!is_stated)
      throw InputError(path.string(), "states no DataRate of 1 to 9000 Hz, and its rows have no times");
    if (rows.size() < 2 || rows.front().time != rows.back().time) return;
    columns.layout.time_unit_s = kNaN;
    header.taken_as = fmt::format("its times are all {:g}: its header's rate of {:.4g} Hz counts",
                                  rows.front().time, stated_hz);
    return;
  }
  const auto frames = static_cast<double>(rows[advancing - 1].frame - rows[0].frame);
  const double span = rows[advancing - 1].time - rows[0].time;
  const auto fits = [&](double unit_s) {
    constexpr double kDiffers = 0.02;
    return std::abs(stated_hz * span * unit_s / frames - 1.0) <= kDiffers;
  };
  if (fits(1.0)) return;
  const std::pair<double, const char*> units[] = {{1e-3, "are milliseconds"},
                                                  {1e-6, "are microseconds"},
                                                  {1e-9, "are nanoseconds"},
                                                  {1.0 / stated_hz, "count frames"}};
  for (const auto& [unit_s, what] : units)
    if (is_stated && fits(unit_s)) {
      columns.layout.time_unit_s = unit_s;
      header.taken_as = fmt::format("its times {}: its header's rate of {:.4g} Hz counts", what, stated_hz);
      return;
    }
  header.export_rate_hz = kNaN;
  const double rate_hz = static_cast<double>(advancing - 1) / span;
  header.taken_as =
      fmt::format("its rows are {:.4g} s apart, {:.4g} Hz, and its header states {}: the times count",
                  1.0 / rate_hz, rate_hz, is_stated ? fmt::format("{:.4g} Hz", stated_hz) : "no rate");
}

}  // namespace trilat
