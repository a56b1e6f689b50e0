// SPDX-License-Identifier: MIT
#include "datasets/mocap/joint_csv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/base/time.h"
#include "datasets/mocap/csv_cell.h"
#include "datasets/mocap/line_reader.h"

namespace trilat {
namespace {

constexpr std::array kJointColumns{"time_s", "joint", "x_m", "y_m", "z_m"};
constexpr std::size_t kReadBytes = 1 << 20;

// The places of the columns in a row of names; those that are not there are as far as the row is long.
std::array<std::size_t, kJointColumns.size()> joint_columns(const std::vector<std::string>& names) {
  std::array<std::size_t, kJointColumns.size()> places{};
  for (std::size_t c = 0; c < kJointColumns.size(); ++c)
    places[c] = static_cast<std::size_t>(std::ranges::find(names, kJointColumns[c]) - names.begin());
  return places;
}

// The names of the columns, of a file that has any rows.
std::vector<std::string> column_names(LineReader& lines) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  std::string_view line;
  if (!lines.next(line)) return {};
  if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  return split_csv(line);
}

}  // namespace

bool is_joint_csv(const std::filesystem::path& path) {
  LineReader lines(path, kReadBytes);
  const std::vector<std::string> names = column_names(lines);
  const auto places = joint_columns(names);
  return places[0] < names.size() && places[1] < names.size();
}

MocapPositions read_joint_csv(const std::filesystem::path& path) {
  LineReader lines(path, kReadBytes);
  const std::vector<std::string> names = column_names(lines);
  const auto places = joint_columns(names);
  for (std::size_t c = 0; c < places.size(); ++c)
    if (places[c] == names.size())
      throw InputError(lines.place(), fmt::format("has no column {}; needed are {}", kJointColumns[c],
                                                  fmt::join(kJointColumns, ", ")));
  struct Row {
    std::int64_t time_ns;
    std::size_t joint;
    Eigen::Vector3d position_m;
  };
  std::vector<Row> rows;
  MocapPositions positions;
  positions.header.format = "joints as CSV";
  std::map<std::string, std::size_t> joints;
  FarNumbers far;
  for (std::string_view line; lines.next(line);) {
    const std::vector<std::string> cells = split_csv(line);
    if (cells.size() < names.size() && !lines.terminated()) positions.anomalies.truncated_last_row = true;
    if (cells.size() < names.size() && (line.empty() || !lines.terminated())) continue;
    if (cells.size() != names.size())
      throw InputError(lines.place(),
                       fmt::format("has {} cells under {} columns", cells.size(), names.size()));
    const auto number = [&](std::size_t c) {
      double value = kMissing;
      const CellKind kind = parse_cell(cells[places[c]], value);
      if (kind == CellKind::unreadable)
        throw InputError(lines.place(), fmt::format("{} is \"{}\", which is not a number", kJointColumns[c],
                                                    cells[places[c]]));
      return kind == CellKind::number ? value : kMissing;
    };
    const double time_s = number(0);
    if (!(std::abs(time_s) <= kLatest_s)) throw InputError(lines.place(), "has no time_s");
    const auto [joint, is_new] = joints.try_emplace(cells[places[1]], joints.size());
    if (is_new) positions.header.assets.push_back({AssetType::marker, joint->first, "", "", true});
    Eigen::Vector3d position_m(number(2), number(3), number(4));
    if (!position_m.allFinite()) position_m.setConstant(kMissing);
    for (const double x_m : position_m)
      if (std::abs(x_m) > kFarthest_m) {
        far.add(x_m, [&] { return InputError(lines.place(), cells[places[1]] + ' ' + kTooFar); });
        position_m.setConstant(kFilled);
        break;
      }
    rows.push_back({duration_from_s(time_s).ns, joint->second, position_m});
  }
  far.end();
  if (rows.empty()) throw InputError(path.string(), "holds no joints");
  std::ranges::stable_sort(rows, {}, &Row::time_ns);
  const std::int64_t first_ns = rows.front().time_ns;
  positions.first_s = 1e-9 * static_cast<double>(first_ns);
  for (const Row& row : rows)
    if (positions.time.empty() || positions.time.back().ns < row.time_ns - first_ns)
      positions.time.push_back({row.time_ns - first_ns});
  positions.position_m.assign(joints.size(), std::vector<Eigen::Vector3d>(
                                                 positions.time.size(), Eigen::Vector3d::Constant(kMissing)));
  std::size_t frame = 0;
  for (const Row& row : rows) {
    while (positions.time[frame].ns < row.time_ns - first_ns) ++frame;
    Eigen::Vector3d& position_m = positions.position_m[row.joint][frame];
    if (position_m.allFinite() && row.position_m.allFinite())
      throw InputError(
          path.string(),
          fmt::format("has {} twice at {:.6f} s; the joints of one person are wanted",
                      positions.header.assets[row.joint].name, 1e-9 * static_cast<double>(row.time_ns)));
    if (!position_m.allFinite()) position_m = row.position_m;
  }
  positions.missing = remove_missing(positions.time, positions.position_m);
  return positions;
}

}  // namespace trilat
