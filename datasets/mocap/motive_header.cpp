// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "datasets/base/error.h"
#include "datasets/mocap/column_header.h"

namespace trilat {
namespace {

using Cells = std::vector<std::string>;

constexpr std::size_t kMaxHeaderRows = 64;
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

bool is_key(const std::string& cell) { return std::ranges::find(kKeys, cell) != kKeys.end(); }

// Whether a quoted cell goes on in the next line: notes may hold line breaks.
bool is_open(std::string_view text) {
  bool quoted = false, at_start = true;
  for (const char c : text) {
    if (quoted) {
      quoted = c != '"';  // a doubled quote opens the cell again
    } else if (c == '"' && at_start) {
      quoted = true;
      continue;
    }
    at_start = c == ',' || (c == '"' && !quoted);
  }
  return quoted;
}

// The line with those that its quoted cells go on in.
std::string whole_record(LineReader& lines, std::string_view line) {
  std::string record(line);
  for (std::size_t more = 0; more < kMaxHeaderRows && is_open(record) && lines.next(line); ++more)
    record.append("\n").append(line);
  return record;
}

// Free text may hold commas and runs to the next key; any other value is one cell.
HeaderValues read_keys(const Cells& cells) {
  HeaderValues values;
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

MocapHeader header_from(const HeaderKeys& keys) {
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
  header.length_unit = keys.length_unit("Length Units");
  const std::string space = keys.text("Coordinate Space");
  if (!space.empty()) header.coordinate_space = space;
  return header;
}

using Cells = std::vector<std::string>;

// "Position,Position,…" is the row of kinds.
struct HeadingRows {
  Cells type;
  Cells name;
  Cells id;
  Cells parent;
  Cells kind;
};

const std::string& cell_of(const Cells& row, std::size_t column) {
  static const std::string empty;
  return column < row.size() ? row[column] : empty;
}

HeadingRows rows_by_label(const std::vector<Cells>& rows) {
  HeadingRows result;
  for (const Cells& row : rows) {
    const std::string& label = cell_of(row, 1);
    if (label == "Type") result.type = row;
    if (label == "Name") result.name = row;
    if (label == "ID") result.id = row;
    if (label == "Parent") result.parent = row;
    if (label.empty()) result.kind = row;
  }
  return result;
}

HeadingRows identify(const std::vector<Cells>& rows, const std::string& place) {
  const bool labelled = std::ranges::any_of(rows, [](const Cells& row) { return cell_of(row, 1) == "Type"; });
  if (labelled) return rows_by_label(rows);
  if (rows.empty()) return {};
  if (rows.size() != 4)
    throw InputError(
        place, "there are " + std::to_string(rows.size()) +
                   " unlabelled rows above this one; it takes four: type, name, ID and Rotation/Position");
  return {rows[0], rows[1], rows[2], {}, rows[3]};
}

bool is_fixed_column(const std::string& axis) { return axis == "Frame" || axis.starts_with("Time"); }

bool is_time_code(const std::string& axis) {
  return axis.starts_with("TimeCode") || axis.starts_with("Timecode") || axis.starts_with("Time Code");
}

std::size_t width_of(const HeadingRows& rows, const Cells& axes) {
  std::size_t width = 0;
  for (const Cells* row : {&rows.type, &rows.name, &rows.id, &rows.kind, &axes})
    for (std::size_t i = 0; i < row->size(); ++i)
      if (!(*row)[i].empty()) width = std::max(width, i + 1);
  return width;
}

// Returns 0, 1 or 2 for a column that holds an asset's position along x, y or z, and kSlotsPerAsset for every
// other column, such as a rotation or the quality of a marker.
std::size_t slot_of(const std::string& kind, const std::string& axis) {
  if (axis.size() != 1 || kind != "Position") return kSlotsPerAsset;
  return std::min(std::string_view("XYZ").find(axis[0]), kSlotsPerAsset);
}

void check_columns(const MocapAsset& asset, const AssetColumns& columns, const std::string& place) {
  if (asset.has_position && std::ranges::find(columns, kNoColumn) != columns.end())
    throw InputError(place, std::string(name_of(asset.type)) + " \"" + asset.name +
                                "\" has not all of the columns Position X, Y and Z");
}

}  // namespace

ColumnHeader read_motive_header(LineReader& lines, std::string_view first_line) {
  const std::string first_place = lines.place();
  Cells keys = split_csv(whole_record(lines, first_line));
  std::vector<Cells> rows;
  bool keys_ended = false;
  std::string_view line;
  for (std::size_t count = 1; lines.next(line); ++count) {
    Cells cells = split_csv(whole_record(lines, line));
    if (is_axis_row(cells)) {
      ColumnHeader result;
      result.header = header_from(HeaderKeys(read_keys(keys), first_place));
      result.layout = read_motive_columns(rows, cells, lines.place(), result.header);
      return result;
    }
    if (count >= kMaxHeaderRows) break;
    if (is_blank(cells)) {
      keys_ended = true;
    } else if (std::ranges::any_of(cells, is_key)) {
      // Also behind a blank line: that one, and what stood before this, belonged to the notes.
      keys_ended = false;
      rows.clear();
      keys.insert(keys.end(), cells.begin(), cells.end());
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

ColumnLayout read_motive_columns(const std::vector<Cells>& rows, const Cells& axes, const std::string& place,
                                 MocapHeader& header) {
  const HeadingRows headings = identify(rows, place);
  ColumnLayout layout;
  layout.used_columns = width_of(headings, axes);
  layout.written_columns = std::max(axes.size(), layout.used_columns);
  std::size_t first = 0;
  for (; first < axes.size() && is_fixed_column(axes[first]); ++first)
    if (first > 0 && !is_time_code(axes[first])) layout.time_column = first;

  std::map<std::tuple<std::string, std::string, std::string>, std::size_t> known;
  for (std::size_t column = first; column < layout.used_columns; ++column) {
    const std::string& kind = cell_of(headings.kind, column);
    const std::size_t slot = slot_of(kind, cell_of(axes, column));
    const bool is_position = slot != kSlotsPerAsset;
    if (!is_position && kind != "Rotation") continue;
    const std::string& type = cell_of(headings.type, column);
    const std::string& name = cell_of(headings.name, column);
    const std::string& id = cell_of(headings.id, column);
    auto [entry, is_new] = known.try_emplace({type, name, id}, header.assets.size());
    // A heading (type, name, ID) that is repeated starts another asset.
    if (!is_new && is_position && layout.columns[entry->second][slot] != kNoColumn) {
      entry->second = header.assets.size();
      is_new = true;
    }
    if (is_new) {
      header.assets.push_back({.type = asset_type_from_motive(type),
                               .name = name.empty() ? "column " + std::to_string(column + 1) : name,
                               .id = id,
                               .parent = cell_of(headings.parent, column)});
      layout.columns.emplace_back().fill(kNoColumn);
    }
    if (!is_position) continue;  // of an asset without a position the name is known
    layout.columns[entry->second][slot] = column;
    header.assets[entry->second].has_position = true;
  }
  for (std::size_t i = 0; i < header.assets.size(); ++i)
    check_columns(header.assets[i], layout.columns[i], place);
  return layout;
}

}  // namespace trilat
