// SPDX-License-Identifier: MIT
#include "datasets/mocap/trackable_header.h"

#include <algorithm>
#include <array>
#include <limits>

#include "datasets/base/error.h"
#include "datasets/mocap/csv_cell.h"

namespace trilat {
namespace {

constexpr std::array<std::string_view, 7> kRowTypes{"comment",   "info",      "righthanded", "lefthanded",
                                                    "trackable", "rigidbody", "frame"};

void read_info(std::string_view line, TrackableHeader& result) {
  const auto cells = split_csv(line);
  if (cells.size() < 3) return;
  if (cells[1] == "version" && cells[2].starts_with("1.1")) {
    result.header.format = "OptiTrack row format 1.1";
    result.cells_per_solved_marker = 4;
    result.cells_per_visible_marker = 5;
  }
  std::int64_t frames = 0;
  if (cells[1] == "framecount" && parse_integer(cells[2], frames))
    result.header.total_exported_frames = frames;
}

void define_body(std::string_view line, const std::string& place, TrackableHeader& result) {
  RowCells cells(line, place);
  cells.skip(2);
  TrackableBody body;
  body.id = cells.integer("body ID");
  body.marker_count = cells.count("marker count");
  if (!cells.complete())
    throw InputError(place, "a body is defined by its name, ID, marker count and markers");
  for (const TrackableBody& other : result.bodies)
    if (other.id == body.id)
      throw InputError(place, "the body ID " + std::to_string(body.id) + " is defined twice");
  body.asset = result.header.assets.size();
  result.bodies.push_back(body);
  result.header.assets.push_back({.type = AssetType::rigid_body,
                                  .name = split_csv(line)[1],
                                  .id = std::to_string(body.id),
                                  .parent = {},
                                  .has_rotation = true,
                                  .has_position = true});
}

std::size_t define_markers(AssetType type, const TrackableBody& body, std::vector<MocapAsset>& assets) {
  const std::size_t first = assets.size();
  const std::string owner = assets[body.asset].name;
  for (std::int64_t i = 1; i <= body.marker_count; ++i)
    assets.push_back({.type = type,
                      .name = owner + ":Marker" + std::to_string(i),
                      .id = std::to_string(body.id),
                      .parent = owner,
                      .has_rotation = false,
                      .has_position = true});
  return first;
}

void read_ahead(std::string_view frame_line, LineReader& lines, TrackableHeader& result) {
  if (!lines.terminated()) {
    lines.unread();
    return;
  }
  RowCells cells(frame_line, lines.place());
  cells.skip(1);
  result.header.first_frame = cells.integer("frame number");
  result.first_frame_line = frame_line;
  std::string_view line;
  if (!lines.next(line)) return;
  if (is_body_row(line)) {
    for (TrackableBody& body : result.bodies)
      body.first_solved = define_markers(AssetType::rigid_body_marker, body, result.header.assets);
    for (TrackableBody& body : result.bodies)
      body.first_marker = define_markers(AssetType::marker, body, result.header.assets);
  }
  lines.unread();
}

constexpr std::int64_t kHighestCount = 10'000;

}  // namespace

std::string_view row_type(std::string_view line) {
  const auto type = line.substr(0, line.find(','));
  return type.substr(0, type.find_last_not_of(" \t") + 1);
}

bool is_body_row(std::string_view line) {
  const auto type = row_type(line);
  return type == "trackable" || type == "rigidbody";
}

bool is_known_row(std::string_view line) {
  return std::ranges::find(kRowTypes, row_type(line)) != kRowTypes.end();
}

void refuse_row(std::string_view line, const std::string& place) {
  std::string known;
  for (const std::string_view type : kRowTypes) known += (known.empty() ? "" : ", ") + std::string(type);
  throw InputError(place, "the row type \"" + std::string(row_type(line).substr(0, 40)) +
                              "\" is unknown; known are: " + known);
}

TrackableHeader read_trackable_header(LineReader& lines, std::string_view first_line) {
  TrackableHeader result;
  result.header.format = "OptiTrack row format 1.0";
  std::string_view line = first_line;
  do {
    const std::string_view type = row_type(line);
    if (type == "frame") {
      read_ahead(line, lines, result);
      return result;
    }
    if (type == "lefthanded") result.header.left_handed = true;
    if (type == "info") read_info(line, result);
    if (is_body_row(line)) define_body(line, lines.place(), result);
    if (!type.empty() && !is_known_row(line) && lines.terminated()) refuse_row(line, lines.place());
  } while (lines.next(line));
  if (result.bodies.empty())
    throw InputError(lines.place(), "the file ends before any \"trackable\", \"rigidbody\" or \"frame\" row");
  return result;
}

std::string_view RowCells::text() {
  ++column_;
  if (at_end_) {
    complete_ = false;
    return {};
  }
  const char* const end = line_.data() + line_.size();
  const auto size = static_cast<std::size_t>(end_of_cell(line_.data(), end) - line_.data());
  const std::string_view cell = line_.substr(0, size);
  at_end_ = size == line_.size();
  line_.remove_prefix(at_end_ ? size : size + 1);
  return cell;
}

void RowCells::skip(std::int64_t count) {
  for (std::int64_t i = 0; i < count && complete_; ++i) text();
}

std::int64_t RowCells::integer(const char* what) {
  const std::string_view cell = text();
  std::int64_t value = 0;
  if (complete_ && !parse_integer(cell, value)) refuse(cell, what);
  return value;
}

std::int64_t RowCells::count(const char* what) {
  const std::int64_t value = integer(what);
  if (value < 0 || value > kHighestCount) refuse(std::to_string(value), what);
  return value;
}

double RowCells::number(const char* what) {
  const std::string_view cell = text();
  double value = 0.0;
  const CellKind kind = parse_cell(cell, value);
  if (kind == CellKind::unreadable) refuse(cell, what);
  return kind == CellKind::number ? value : std::numeric_limits<double>::quiet_NaN();
}

Eigen::Vector3d RowCells::position(const char* what) {
  Eigen::Vector3d result;
  for (double& component : result) component = number(what);
  return result;
}

std::size_t RowCells::left() const {
  return at_end_ ? 0 : 1 + static_cast<std::size_t>(std::ranges::count(line_, ','));
}

void RowCells::refuse(std::string_view cell, const char* what) const {
  throw InputError(place_, "column " + std::to_string(column_) + ": \"" + std::string(cell.substr(0, 40)) +
                               "\" is not a " + what);
}

}  // namespace trilat
