// SPDX-License-Identifier: MIT
// The row formats 1.0 and 1.1 of Arena, Tracking Tools and early Motive: the first field of a row says what
// it is.
#include <cmath>
#include <map>

#include "datasets/base/error.h"
#include "datasets/mocap/optitrack_format.h"

namespace trilat {
namespace {

constexpr std::uint64_t kMostBodies = 1000;
constexpr std::uint64_t kMostMarkers = 10'000;

bool is_body_row(std::string_view type) { return type == "trackable" || type == "rigidbody"; }

class RowFormat : public OptitrackFormat {
 public:
  RowFormat(CsvLines& lines, std::string_view first_line) : lines_(lines) {
    header.format = "OptiTrack rows 1.0";
    header.rotation_type = "Quaternion";
    header.coordinate_space = "Global";
    std::string_view line = first_line;
    do {
      const auto fields = csv_fields(line);
      if (fields[0] == "frame") {
        pending_ = std::string(line);
        break;
      }
      read_header_row(fields);
    } while (lines_.next(line));
    wanted_.assign(header.assets.size(), true);
  }

  void read_only(const std::vector<std::size_t>& assets) override {
    wanted_.assign(header.assets.size(), false);
    for (std::size_t asset : assets) wanted_.at(asset) = true;
  }

  bool next(MocapFrame& frame) override {
    std::string_view line;
    while (!pending_.empty() || lines_.next(line)) {
      const std::string held = std::move(pending_);
      pending_.clear();
      if (!held.empty()) line = held;
      CsvCells cells(line);
      if (cells.next() != "frame") continue;
      if (!read_frame(cells, frame)) continue;
      read_extended_rows(frame);
      if (header.left_handed)
        for (MocapPose& pose : frame.poses) make_right_handed(pose);
      return true;
    }
    return false;
  }

 private:
  void read_header_row(const std::vector<std::string>& fields) {
    if (fields[0] == "lefthanded") header.left_handed = true;
    if (fields[0] == "info" && fields.size() > 2 && fields[1] == "version")
      header.format = "OptiTrack rows " + fields[2];
    double value = 0.0;
    if (fields[0] == "info" && fields.size() > 2 && fields[1] == "framecount" &&
        parse_cell(fields[2], value) == CellKind::number && value >= 0.0 && value < 1e15)
      header.stated_frames = static_cast<std::int64_t>(value);
    if (is_body_row(fields[0])) define_body(fields);
  }

  void define_body(const std::vector<std::string>& fields) {
    if (fields.size() < 4 || header.assets.size() > kMostBodies)
      throw InputError(lines_.place(), "defines a body without name, id and marker count");
    Body body;
    body.pose = add({AssetType::rigid_body, fields[1], fields[2], true, true});
    double markers = 0.0;
    if (parse_cell(fields[3], markers) != CellKind::number || markers < 0.0 || markers > kMostMarkers)
      throw InputError(lines_.place(), "has \"" + fields[3] + "\" where the number of markers stands");
    for (int m = 0; m < static_cast<int>(markers); ++m) {
      const std::string name = fields[1] + ":Marker" + std::to_string(m + 1);
      body.solved.push_back(add({AssetType::rigid_body_marker, name, fields[2], true, false}));
      body.seen.push_back(add({AssetType::marker, name, fields[2], true, false}));
    }
    if (!bodies_.emplace(fields[2], std::move(body)).second)
      throw InputError(lines_.place(), "defines a body with the id " + fields[2] + " for the second time");
  }

  std::size_t add(MocapAsset asset) {
    header.assets.push_back(std::move(asset));
    return header.assets.size() - 1;
  }

  double number(CsvCells& cells, const char* what) {
    const std::string_view cell = cells.next();
    double value = std::numeric_limits<double>::quiet_NaN();
    switch (parse_cell(cell, value)) {
      case CellKind::number:
        return value;
      case CellKind::not_finite:
        ++anomalies.not_finite_cells;
        return std::numeric_limits<double>::quiet_NaN();
      case CellKind::empty:
        return std::numeric_limits<double>::quiet_NaN();
      case CellKind::text:
        break;
    }
    throw InputError(lines_.place(),
                     "has \"" + std::string(cell.substr(0, 40)) + "\" where " + what + " stands");
  }

  std::uint64_t count(CsvCells& cells, const char* what, std::uint64_t most) {
    const double value = number(cells, what);
    if (!(value >= 0.0 && value <= static_cast<double>(most) && value == std::floor(value)))
      throw InputError(lines_.place(), std::string("has no sensible number where ") + what + " stands");
    return static_cast<std::uint64_t>(value);
  }

  Eigen::Vector3d point(CsvCells& cells, const std::string& asset) {
    Eigen::Vector3d p;
    for (int axis = 0; axis < 3; ++axis) {
      const double value = number(cells, "a coordinate");
      p[axis] = std::isfinite(value) ? checked_metres(value, 1.0, lines_, asset) : value;
    }
    return p;
  }

  bool read_frame(CsvCells& cells, MocapFrame& frame) {
    const double index = number(cells, "the frame number");
    if (!(std::abs(index) < 1e15)) throw InputError(lines_.place(), "has no frame number");
    frame.index = static_cast<std::int64_t>(index);
    frame.printed_time_s = number(cells, "the time");
    if (!(std::abs(frame.printed_time_s) < 1e9)) throw InputError(lines_.place(), "has no time");
    if (last_index_ && frame.index <= *last_index_) {
      ++anomalies.repeated_frames;
      return false;
    }
    if (!last_index_) first_time_s_ = frame.printed_time_s;
    last_index_ = frame.index;
    frame.time.ns = duration_from_s(frame.printed_time_s - first_time_s_).ns;
    frame.poses.assign(header.assets.size(), MocapPose{});
    const std::uint64_t bodies = count(cells, "the number of bodies", kMostBodies);
    for (std::uint64_t b = 0; b < bodies; ++b) read_pose(cells, frame);
    const std::uint64_t markers = count(cells, "the number of markers", kMostMarkers);
    const std::size_t fields_a_marker = header.format == "OptiTrack rows 1.0" ? 4 : 5;
    // the frame's loose markers have no lasting identity; those of bodies come in the rows that follow
    if (markers > 0) cells.skip(fields_a_marker * markers - 1);
    if (markers > 0 && cells.at_end())
      throw InputError(lines_.place(), "ends before its " + std::to_string(markers) + " markers");
    if (markers > 0) cells.next();
    if (!cells.at_end()) ++anomalies.rows_with_extra_fields;
    return true;
  }

  void read_pose(CsvCells& cells, MocapFrame& frame) {
    const std::string id(cells.next());
    const auto body = bodies_.find(id);
    if (body == bodies_.end())
      throw InputError(lines_.place(), "names the body id \"" + id + "\", which no row above defines");
    MocapPose& pose = frame.poses[body->second.pose];
    pose.position_m = point(cells, header.assets[body->second.pose].name);
    for (int i = 0; i < 4; ++i) pose.rotation.coeffs()[i] = number(cells, "a quaternion");
    const double norm = pose.rotation.norm();
    if (norm > 0.5 && norm < 2.0)
      pose.rotation.coeffs() /= norm;
    else
      pose.rotation.coeffs().setConstant(std::numeric_limits<double>::quiet_NaN());
    cells.skip(2);  // yaw, pitch
    if (cells.at_end()) throw InputError(lines_.place(), "ends in the middle of a body");
    cells.next();  // roll
    if (!wanted_[body->second.pose]) pose = MocapPose{};
  }

  // Rows of this frame's bodies, up to the next frame row, which is kept.
  void read_extended_rows(MocapFrame& frame) {
    std::string_view line;
    while (lines_.next(line)) {
      CsvCells cells(line);
      const std::string_view type = cells.next();
      if (type == "frame") {
        if (lines_.line_was_ended())
          pending_ = std::string(line);
        else
          anomalies.truncated_last_row = true;
        return;
      }
      if (!is_body_row(type)) continue;
      if (!lines_.line_was_ended()) {
        anomalies.truncated_last_row = true;
        return;
      }
      read_extended(cells, frame);
    }
  }

  void read_extended(CsvCells& cells, MocapFrame& frame) {
    if (count(cells, "the frame number", std::uint64_t{1} << 50) != static_cast<std::uint64_t>(frame.index)) {
      ++anomalies.repeated_frames;
      return;
    }
    number(cells, "the time");
    cells.next();  // name
    const std::string id(cells.next());
    const auto body = bodies_.find(id);
    if (body == bodies_.end())
      throw InputError(lines_.place(), "names the body id \"" + id + "\", which no row above defines");
    count(cells, "the number of frames since tracked", std::uint64_t{1} << 50);
    const std::uint64_t markers = count(cells, "the number of markers", body->second.solved.size());
    const bool has_ids = header.format != "OptiTrack rows 1.0";
    for (std::uint64_t m = 0; m < markers; ++m) {
      set(frame, body->second.solved[m], cells);
      if (has_ids) cells.next();
    }
    for (std::uint64_t m = 0; m < markers; ++m) set(frame, body->second.seen[m], cells);
  }

  void set(MocapFrame& frame, std::size_t asset, CsvCells& cells) {
    const Eigen::Vector3d p = point(cells, header.assets[asset].name);
    if (wanted_[asset] && p.allFinite()) frame.poses[asset].position_m = p;
  }

  struct Body {
    std::size_t pose = 0;
    std::vector<std::size_t> solved, seen;
  };

  CsvLines& lines_;
  std::string pending_;  // a frame row that was read ahead
  std::map<std::string, Body> bodies_;
  std::vector<bool> wanted_;
  std::optional<std::int64_t> last_index_;
  double first_time_s_ = 0.0;
};

}  // namespace

std::unique_ptr<OptitrackFormat> row_format(CsvLines& lines, std::string_view first_line) {
  return std::make_unique<RowFormat>(lines, first_line);
}

}  // namespace trilat
