// SPDX-License-Identifier: MIT
// Motive's column format, 1.2 to 1.25: a line of keys and values, header rows, then a row a frame.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "datasets/base/error.h"
#include "datasets/mocap/optitrack_format.h"

namespace trilat {
namespace {

constexpr int kMostHeaderRows = 20;
constexpr std::size_t kMostColumns = 200'000;

enum class Channel : std::uint8_t {
  rotation_x,
  rotation_y,
  rotation_z,
  rotation_w,
  position_x,
  position_y,
  position_z,
  none
};

struct Column {
  std::size_t asset = 0;
  Channel channel = Channel::none;
};

struct HeaderRows {
  std::vector<std::string> types, names, ids, kinds, axes;
  std::size_t first_data = 0;
};

bool is_blank(const std::vector<std::string>& fields) {
  return std::all_of(fields.begin(), fields.end(), [](const std::string& f) { return f.empty(); });
}

bool is_fixed_column(const std::string& axis) {
  return axis == "Frame" || axis.starts_with("Time") || axis == "Timecode" || axis == "TimeCode";
}

AssetType type_of(const std::string& text) {
  static const std::map<std::string, AssetType> kTypes{{"Rigid Body", AssetType::rigid_body},
                                                       {"Rigid Body Marker", AssetType::rigid_body_marker},
                                                       {"Marker", AssetType::marker},
                                                       {"Bone", AssetType::bone},
                                                       {"Bone Marker", AssetType::bone_marker}};
  const auto found = kTypes.find(text);
  return found == kTypes.end() ? AssetType::other : found->second;
}

std::string at(const std::vector<std::string>& row, std::size_t column) {
  return column < row.size() ? row[column] : std::string();
}

double number_of(const std::string& text, const CsvLines& lines, const std::string& key) {
  double value = 0.0;
  if (parse_cell(text, value) != CellKind::number)
    throw InputError(lines.path() + ":1", "has \"" + text + "\" under \"" + key + "\", which is no number");
  return value;
}

// Line 1: keys and values in turn; a value may be empty.
void read_keys(const std::vector<std::string>& fields, const CsvLines& lines, MocapHeader& header) {
  std::map<std::string, std::string> values;
  for (std::size_t i = 0; i + 1 < fields.size(); i += 2) values.emplace(fields[i], fields[i + 1]);
  header.format = "Motive CSV " + values["Format Version"];
  header.take_name = values["Take Name"];
  header.capture_start = values["Capture Start Time"];
  header.rotation_type = values["Rotation Type"];
  header.coordinate_space = values["Coordinate Space"];
  const std::string rate = values["Export Frame Rate"].empty() ? "Capture Frame Rate" : "Export Frame Rate";
  if (!values[rate].empty()) {
    header.rate_hz = number_of(values[rate], lines, rate);
    if (!(*header.rate_hz > 0.0 && *header.rate_hz < 1e6))
      throw InputError(lines.path() + ":1", "has the frame rate " + values[rate] + ", which cannot be");
  }
  if (!values["Total Exported Frames"].empty())
    header.stated_frames = static_cast<std::int64_t>(
        std::clamp(number_of(values["Total Exported Frames"], lines, "Total Exported Frames"), 0.0, 1e15));
  const auto unit = length_unit_from_text(values["Length Units"]);
  if (!unit)
    throw InputError(lines.path() + ":1", "has the length unit \"" + values["Length Units"] +
                                              "\"; known are Meters, Centimeters, Millimeters, Inches, Feet");
  header.length_unit = *unit;
}

void check_rotation(const MocapHeader& header, const CsvLines& lines) {
  std::string sorted = header.rotation_type;
  std::sort(sorted.begin(), sorted.end());
  if (header.rotation_type != "Quaternion" && !header.rotation_type.empty() && sorted != "XYZ")
    throw InputError(lines.path() + ":1", "has the rotation type \"" + header.rotation_type +
                                              "\"; known are Quaternion and the six orders of X, Y, Z");
}

// The rows between the first line and the one that starts with "Frame", which gives the axes.
std::vector<std::vector<std::string>> header_rows(CsvLines& lines, std::vector<std::string>& axes) {
  std::vector<std::vector<std::string>> rows;
  std::string_view line;
  for (int i = 0; i < kMostHeaderRows; ++i) {
    if (!lines.next(line)) break;
    std::vector<std::string> fields = csv_fields(line);
    if (fields[0] == "Frame") {
      axes = std::move(fields);
      if (axes.size() > kMostColumns) throw InputError(lines.place(), "has more columns than any export");
      return rows;
    }
    if (!is_blank(fields) || !rows.empty()) rows.push_back(std::move(fields));
  }
  throw InputError(lines.place(),
                   "should be among the header rows, but no row starts with \"Frame\"; is the file cut?");
}

// Header rows carry a label just before the data ("Type", "Name", "ID", "Parent"), or, before 1.22, stand in
// this order without one.
HeaderRows identify(const std::vector<std::vector<std::string>>& rows, std::vector<std::string> axes) {
  HeaderRows result;
  while (result.first_data < axes.size() && is_fixed_column(axes[result.first_data])) ++result.first_data;
  bool labelled = false;
  for (const auto& row : rows) {
    const auto labels_end =
        row.begin() + static_cast<std::ptrdiff_t>(std::min(row.size(), result.first_data));
    const auto has = [&](const char* label) {
      return std::find(row.begin(), labels_end, label) != labels_end;
    };
    std::vector<std::string>* target = has("Type")   ? &result.types
                                       : has("Name") ? &result.names
                                       : has("ID")   ? &result.ids
                                                     : nullptr;
    if (target) {
      *target = row;
      labelled = true;
    }
  }
  if (!labelled && rows.size() >= 4) {
    result.types = rows[0];
    result.names = rows[1];
    result.ids = rows[2];
  }
  if (!rows.empty()) result.kinds = rows.back();
  result.axes = std::move(axes);
  return result;
}

Channel channel_of(const std::string& kind, const std::string& axis) {
  static constexpr std::string_view kAxes = "XYZW";
  const std::size_t index = axis.size() == 1 ? kAxes.find(axis[0]) : std::string_view::npos;
  if (index == std::string_view::npos) return Channel::none;
  if (kind == "Rotation") return static_cast<Channel>(index);
  if (kind == "Position" && index < 3) return static_cast<Channel>(index + 4);
  return Channel::none;
}

std::vector<Column> make_columns(const HeaderRows& rows, MocapHeader& header) {
  std::map<std::tuple<AssetType, std::string, std::string>, std::size_t> known;
  std::vector<Column> columns;
  for (std::size_t c = rows.first_data; c < rows.axes.size(); ++c) {
    const Channel channel = channel_of(at(rows.kinds, c), rows.axes[c]);
    // columns of no asset: Excel's padding
    if (channel == Channel::none && at(rows.types, c).empty() && at(rows.names, c).empty()) {
      columns.push_back({});
      continue;
    }
    MocapAsset asset{type_of(at(rows.types, c)), at(rows.names, c), at(rows.ids, c)};
    if (asset.name.empty()) asset.name = asset.id.empty() ? "unnamed" : "unnamed " + asset.id;
    const auto [entry, fresh] = known.try_emplace({asset.type, asset.name, asset.id}, header.assets.size());
    if (fresh) header.assets.push_back(asset);
    MocapAsset& owner = header.assets[entry->second];
    owner.has_rotation |= channel <= Channel::rotation_w;
    owner.has_position |= channel >= Channel::position_x && channel <= Channel::position_z;
    columns.push_back({entry->second, channel});
  }
  return columns;
}

class ColumnFormat : public OptitrackFormat {
 public:
  ColumnFormat(CsvLines& lines, std::string_view first_line) : lines_(lines) {
    read_keys(csv_fields(first_line), lines, header);
    check_rotation(header, lines);
    std::vector<std::string> axes;
    const auto rows = header_rows(lines, axes);
    const HeaderRows identified = identify(rows, std::move(axes));
    fixed_columns_ = identified.first_data;
    columns_ = make_columns(identified, header);
    metres_per_unit_ = metres_per(header.length_unit);
    wanted_.assign(columns_.size(), true);
    for (std::size_t c = 0; c < columns_.size(); ++c) wanted_[c] = columns_[c].channel != Channel::none;
    find_last_wanted();
  }

  void read_only(const std::vector<std::size_t>& assets) override {
    for (std::size_t c = 0; c < columns_.size(); ++c)
      wanted_[c] = columns_[c].channel != Channel::none &&
                   std::find(assets.begin(), assets.end(), columns_[c].asset) != assets.end();
    find_last_wanted();
  }

  bool next(MocapFrame& frame) override {
    std::string_view line;
    while (lines_.next(line)) {
      if (line.find_first_not_of(", \t") == std::string_view::npos) continue;
      if (!lines_.line_was_ended() && is_cut(line)) {
        anomalies.truncated_last_row = true;
        return false;
      }
      if (read_row(line, frame)) return true;
    }
    return false;
  }

 private:
  void find_last_wanted() {
    end_wanted_ = columns_.size();
    while (end_wanted_ > 0 && !wanted_[end_wanted_ - 1]) --end_wanted_;
  }

  // A last row that does not end in a line end may have lost cells, or digits of its last cell.
  bool is_cut(std::string_view line) const {
    return static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1 <
           fixed_columns_ + columns_.size();
  }

  bool read_row(std::string_view line, MocapFrame& frame) {
    CsvCells cells(line);
    double index = 0.0;
    const std::string_view first = cells.next();
    if (parse_cell(first, index) != CellKind::number || index != std::floor(index) || std::abs(index) > 1e15)
      throw InputError(lines_.place(),
                       "has \"" + std::string(first.substr(0, 40)) + "\" where the frame number stands");
    frame.index = static_cast<std::int64_t>(index);
    frame.printed_time_s = std::numeric_limits<double>::quiet_NaN();
    if (fixed_columns_ > 1) parse_cell(cells.next(), frame.printed_time_s);
    if (fixed_columns_ > 2) cells.skip(fixed_columns_ - 2);
    if (last_index_ && frame.index <= *last_index_) {
      ++anomalies.repeated_frames;
      return false;
    }
    if (!last_index_) {
      first_index_ = frame.index;
      first_time_s_ = frame.printed_time_s;
    }
    last_index_ = frame.index;
    set_time(frame);
    read_cells(cells, frame);
    return true;
  }

  void set_time(MocapFrame& frame) const {
    if (header.rate_hz)
      frame.time.ns = duration_from_s(static_cast<double>(frame.index - first_index_) / *header.rate_hz).ns;
    else if (std::isfinite(frame.printed_time_s) && std::isfinite(first_time_s_))
      frame.time.ns = duration_from_s(frame.printed_time_s - first_time_s_).ns;
    else
      throw InputError(lines_.place(), "has no time, and the header no frame rate");
  }

  void read_cells(CsvCells& cells, MocapFrame& frame) {
    frame.poses.assign(header.assets.size(), MocapPose{});
    std::size_t to_skip = 0;
    for (std::size_t c = 0; c < end_wanted_ && !cells.at_end(); ++c) {
      if (!wanted_[c]) {
        ++to_skip;
        continue;
      }
      if (to_skip > 0) cells.skip(to_skip);
      to_skip = 0;
      if (cells.at_end()) break;
      read_cell(cells.next(), columns_[c], frame);
    }
    if (end_wanted_ == columns_.size()) count_extra(cells);
    finish_rotations(frame);
  }

  void read_cell(std::string_view cell, const Column& column, MocapFrame& frame) {
    double value = 0.0;
    switch (parse_cell(cell, value)) {
      case CellKind::empty:
        return;
      case CellKind::not_finite:
        ++anomalies.not_finite_cells;
        return;
      case CellKind::text:
        throw InputError(lines_.place(), "has \"" + std::string(cell.substr(0, 40)) + "\" as a number of \"" +
                                             header.assets[column.asset].name + '"');
      case CellKind::number:
        break;
    }
    MocapPose& pose = frame.poses[column.asset];
    const auto channel = static_cast<int>(column.channel);
    if (column.channel >= Channel::position_x)
      pose.position_m[channel - 4] =
          checked_metres(value, metres_per_unit_, lines_, header.assets[column.asset].name);
    else
      pose.rotation.coeffs()[channel] = value;  // x, y, z, w; or Euler angles in x, y, z
  }

  void count_extra(CsvCells& cells) {
    bool extra = false;
    while (!cells.at_end()) extra |= !cells.next().empty();
    if (extra) ++anomalies.rows_with_extra_fields;
  }

  // Rotations that are not whole are missing; Euler angles become quaternions; lengths are made one.
  void finish_rotations(MocapFrame& frame) const {
    for (std::size_t a = 0; a < header.assets.size(); ++a) {
      if (!header.assets[a].has_rotation) continue;
      Eigen::Quaterniond& q = frame.poses[a].rotation;
      if (header.rotation_type.size() == 3) q = from_euler(q.x(), q.y(), q.z());
      const double norm = q.norm();
      if (!(norm > 0.5 && norm < 2.0))
        q.coeffs().setConstant(std::numeric_limits<double>::quiet_NaN());
      else
        q.coeffs() /= norm;
    }
  }

  Eigen::Quaterniond from_euler(double x_deg, double y_deg, double z_deg) const {
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    for (char axis : header.rotation_type) {
      const double angle_deg = axis == 'X' ? x_deg : axis == 'Y' ? y_deg : z_deg;
      const Eigen::Vector3d direction = axis == 'X'   ? Eigen::Vector3d::UnitX()
                                        : axis == 'Y' ? Eigen::Vector3d::UnitY()
                                                      : Eigen::Vector3d::UnitZ();
      q = q * Eigen::AngleAxisd(angle_deg * kRadPerDegree, direction);
    }
    return q;
  }

  CsvLines& lines_;
  std::size_t fixed_columns_ = 0, end_wanted_ = 0;
  std::vector<Column> columns_;
  std::vector<bool> wanted_;
  double metres_per_unit_ = 1.0;
  std::optional<std::int64_t> last_index_;
  std::int64_t first_index_ = 0;
  double first_time_s_ = 0.0;
};

}  // namespace

std::unique_ptr<OptitrackFormat> column_format(CsvLines& lines, std::string_view first_line) {
  return std::make_unique<ColumnFormat>(lines, first_line);
}

}  // namespace trilat
