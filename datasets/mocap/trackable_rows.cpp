// SPDX-License-Identifier: MIT
#include "datasets/mocap/trackable_rows.h"

#include <cmath>
#include <numeric>
#include <utility>

#include "datasets/base/error.h"

namespace trilat {
namespace {

bool is_blank_row(std::string_view line) { return line.find_first_not_of(", \t") == std::string_view::npos; }

// The last cell of an unfinished row may lack digits.
std::string_view trusted_part(std::string_view line, bool finished) {
  return finished ? line : line.substr(0, line.rfind(',') == line.npos ? 0 : line.rfind(','));
}

}  // namespace

TrackableRows::TrackableRows(LineReader& lines, TrackableHeader header)
    : lines_(lines), header_(std::move(header)) {
  std::vector<std::size_t> all(header_.header.assets.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  read_only(all);
}

void TrackableRows::read_only(const std::vector<std::size_t>& assets) {
  wanted_.assign(header_.header.assets.size(), 0);
  for (const std::size_t asset : assets) wanted_.at(asset) = 1;
}

bool TrackableRows::next(MocapFrame& frame, MocapAnomalies& anomalies) {
  if (!header_.first_frame_line.empty()) {
    const std::string line = std::exchange(header_.first_frame_line, {});
    if (read_frame(line, true, frame, anomalies)) return true;
  }
  std::string_view line;
  while (lines_.next(line)) {
    if (row_type(line) == "frame") {
      if (read_frame(line, lines_.terminated(), frame, anomalies)) return true;
    } else if (!is_known_row(line) && !is_blank_row(line) && lines_.terminated()) {
      refuse_row(line, lines_.place());
    }
  }
  return false;
}

bool TrackableRows::read_frame(std::string_view line, bool finished, MocapFrame& frame,
                               MocapAnomalies& anomalies) {
  RowCells cells(trusted_part(line, finished), lines_.place());
  cells.skip(1);
  frame.index = cells.integer("frame number");
  frame.printed_time_s = cells.number("time");
  frame.poses.assign(wanted_.size(), MocapPose());
  for (std::int64_t left = cells.count("body count"); left > 0 && cells.complete(); --left)
    read_body(cells, frame, anomalies);
  const std::int64_t visible = cells.count("marker count");
  if (!finished) anomalies.truncated_last_row = true;
  if (!cells.complete()) {
    if (!finished) return false;
    throw InputError(lines_.place(), "the frame row ends too early");
  }
  cells.skip(visible * static_cast<std::int64_t>(header_.cells_per_visible_marker));
  if (cells.left() > 0) ++anomalies.rows_with_extra_fields;
  if (!set_time(frame, anomalies)) return false;
  read_extended_rows(frame, anomalies);
  return true;
}

void TrackableRows::read_body(RowCells& cells, MocapFrame& frame, MocapAnomalies& anomalies) const {
  const std::int64_t id = cells.integer("body ID");
  const Eigen::Vector3d position_m = cells.position("position");
  const double x = cells.number("quaternion");
  const double y = cells.number("quaternion");
  const double z = cells.number("quaternion");
  const double w = cells.number("quaternion");
  cells.skip(3);
  if (!cells.complete()) return;
  const std::size_t asset = body_of(id).asset;
  MocapPose* const pose = pose_of(asset, frame);
  if (!pose) return;
  set_position(asset, position_m, frame, anomalies);
  MocapPose turned;
  turned.rotation = rotation_from_printed(x, y, z, w);
  if (!turned.has_rotation() && !std::isnan(x + y + z + w)) ++anomalies.invalid_rotations;
  if (header_.header.left_handed) make_right_handed(turned);
  pose->rotation = turned.rotation;
}

void TrackableRows::read_extended_rows(MocapFrame& frame, MocapAnomalies& anomalies) {
  std::string_view line;
  while (lines_.next(line)) {
    if (!is_body_row(line)) {
      lines_.unread();
      return;
    }
    read_extended(line, frame, anomalies);
  }
}

void TrackableRows::read_extended(std::string_view line, MocapFrame& frame, MocapAnomalies& anomalies) const {
  const bool finished = lines_.terminated();
  if (!finished) anomalies.truncated_last_row = true;
  RowCells cells(trusted_part(line, finished), lines_.place());
  cells.skip(4);
  const std::int64_t id = cells.integer("body ID");
  const std::int64_t frames_since_tracked = cells.integer("number of frames since last tracked");
  const std::int64_t count = cells.count("marker count");
  const auto markers = static_cast<std::size_t>(count);
  const std::size_t needed = markers * (header_.cells_per_solved_marker + 5) + 1;
  if (!cells.complete() || cells.left() < needed) {
    if (!finished) return;
    throw InputError(lines_.place(), "the extended row ends too early");
  }
  if (cells.left() > needed) ++anomalies.rows_with_extra_fields;
  const TrackableBody& body = body_of(id);
  if (count != body.marker_count)
    throw InputError(lines_.place(), "the body has " + std::to_string(count) + " markers here and " +
                                         std::to_string(body.marker_count) + " in its definition");
  // Files that begin with a frame row alone do not list markers as assets.
  if (body.first_marker == 0) return;
  for (std::size_t i = 0; i < markers; ++i) {
    const Eigen::Vector3d solved_m = cells.position("position");
    cells.skip(static_cast<std::int64_t>(header_.cells_per_solved_marker) - 3);
    if (frames_since_tracked == 0) set_position(body.first_solved + i, solved_m, frame, anomalies);
  }
  for (std::size_t i = 0; i < markers; ++i)
    set_position(body.first_marker + i, cells.position("position"), frame, anomalies);
}

bool TrackableRows::set_time(MocapFrame& frame, MocapAnomalies& anomalies) {
  const double stamp_s = frame.printed_time_s;
  if (!(std::abs(stamp_s) <= kLatest_s))
    throw InputError(lines_.place(), "the frame row has no sensible time");
  if (!started_) first_stamp_s_ = stamp_s;
  if (started_ && stamp_s <= last_stamp_s_) {
    ++anomalies.repeated_frames;
    return false;
  }
  started_ = true;
  last_stamp_s_ = stamp_s;
  frame.time = MocapTime{} + duration_from_s(stamp_s - first_stamp_s_);
  return true;
}

void TrackableRows::set_position(std::size_t asset, const Eigen::Vector3d& position_m, MocapFrame& frame,
                                 MocapAnomalies& anomalies) const {
  MocapPose* const pose = pose_of(asset, frame);
  if (!pose) return;
  if ((position_m.array().abs() > kFarthest_m).any())
    throw InputError(lines_.place(), key_of(header_.header, asset) + " " + kTooFar);
  if (position_m.hasNaN()) {
    if (!position_m.array().isNaN().all()) ++anomalies.partial_poses;
    return;
  }
  pose->position_m = position_m;
  if (header_.header.left_handed) pose->position_m.z() = -position_m.z();
}

const TrackableBody& TrackableRows::body_of(std::int64_t id) const {
  for (const TrackableBody& body : header_.bodies)
    if (body.id == id) return body;
  throw InputError(lines_.place(),
                   "the body ID " + std::to_string(id) + " is not defined before the first frame");
}

MocapPose* TrackableRows::pose_of(std::size_t asset, MocapFrame& frame) const {
  return wanted_[asset] ? &frame.poses[asset] : nullptr;
}

}  // namespace trilat
