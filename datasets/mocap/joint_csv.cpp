// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/base/median.h"
#include "datasets/base/time.h"
#include "datasets/mocap/missing_positions.h"
#include "datasets/mocap/mocap_text.h"
#include "datasets/mocap/read_mocap.h"

namespace trilat {
namespace {

constexpr std::array kJointColumns{"time_s", "joint", "x_m", "y_m", "z_m"};
constexpr std::size_t kReadBytes = 1 << 20;
constexpr double kLatestCsv_s = 9e9;  // in seconds since 1970 the year 2255, in nanoseconds what 64 bits hold

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

// The unit of a file's times, in seconds: one, unless the rate would then be none of a camera; milliseconds,
// micro- or nanoseconds whose rate is one. InputError for others.
double unit_of(const std::vector<double>& times, const std::string& place,
               std::vector<std::string>& taken_as) {
  constexpr double kMinRate_hz = 0.5, kMinCamera_hz = 5.0, kMaxCamera_hz = 1000.0;
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  const double step = steps.empty() ? 1.0 : upper_median(steps);
  if (step <= 1.0 / kMinRate_hz) return 1.0;
  const auto is_camera = [&](const std::pair<double, const char*>& unit) {
    return step * unit.first >= 1.0 / kMaxCamera_hz && step * unit.first <= 1.0 / kMinCamera_hz;
  };
  const std::pair<double, const char*> units[] = {
      {1e-3, "milliseconds"}, {1e-6, "microseconds"}, {1e-9, "nanoseconds"}};
  const auto unit = std::ranges::find_if(units, is_camera);
  if (unit == std::end(units))
    throw InputError(
        place,
        fmt::format("time_s steps by {:g}; in seconds, milliseconds, microseconds or nanoseconds that is "
                    "not a camera's frame rate. Write time_s in seconds",
                    step));
  taken_as.push_back(fmt::format("time_s goes from {:g} to {:g} in steps of {:g}: taken as {}, {:.4g} Hz",
                                 times.front(), times.back(), step, unit->second,
                                 1.0 / (step * unit->first)));
  return unit->first;
}

}  // namespace

bool is_joint_csv(const std::filesystem::path& path) {
  LineReader lines(path, kReadBytes);
  const std::vector<std::string> names = column_names(lines);
  const auto places = joint_columns(names);
  return places[0] < names.size() && places[1] < names.size();
}

MocapTake read_joint_csv(const std::filesystem::path& path) {
  LineReader lines(path, kReadBytes);
  const std::vector<std::string> names = column_names(lines);
  const auto places = joint_columns(names);
  for (std::size_t c = 0; c < places.size(); ++c)
    if (places[c] == names.size())
      throw InputError(lines.place(), fmt::format("has no column {}; needed are {}", kJointColumns[c],
                                                  fmt::join(kJointColumns, ", ")));
  struct Row {
    double time_s;
    std::size_t joint;
    Eigen::Vector3d position_m;
  };
  std::vector<Row> rows;
  MocapTake positions;
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
      double value = kNaN;
      const CellKind kind = parse_cell(cells[places[c]], value);
      if (kind == CellKind::unreadable)
        throw InputError(lines.place(), fmt::format("{} is \"{}\", which is not a number", kJointColumns[c],
                                                    cells[places[c]]));
      return kind == CellKind::number ? value : kNaN;
    };
    const double time_s = number(0);
    if (!std::isfinite(time_s)) throw InputError(lines.place(), "has no time_s");
    const auto [joint, is_new] = joints.try_emplace(cells[places[1]], joints.size());
    if (is_new) positions.header.assets.push_back({AssetType::marker, joint->first, "", "", true});
    Eigen::Vector3d position_m(number(2), number(3), number(4));
    if (!position_m.allFinite()) position_m.setConstant(kNaN);
    for (const double x_m : position_m)
      if (std::abs(x_m) > kMaxDistance_m)
        far.add(x_m, [&] { return InputError(lines.place(), cells[places[1]] + ' ' + kTooFar); });
    if (position_m.cwiseAbs().maxCoeff() > kMaxDistance_m) position_m.setConstant(kFilled);
    rows.push_back({time_s, joint->second, position_m});
  }
  far.end();
  if (rows.empty()) throw InputError(path.string(), "holds no joints");
  std::ranges::stable_sort(rows, {}, &Row::time_s);
  std::vector<double> times_s;
  for (const Row& row : rows)
    if (times_s.empty() || times_s.back() < row.time_s) times_s.push_back(row.time_s);
  const double unit_s = unit_of(times_s, path.string(), positions.taken_as);
  positions.first_s = times_s.front() * unit_s;
  const double latest_s = std::max({std::abs(positions.first_s), std::abs(times_s.back() * unit_s),
                                    (times_s.back() - times_s.front()) * unit_s});
  if (!(latest_s <= kLatestCsv_s))
    throw InputError(path.string(),
                     fmt::format("has a time_s of {:g}, which no clock shows", times_s.back()));
  const auto since_first_ns = [&](double time_s) {
    return duration_from_s((time_s - times_s.front()) * unit_s).ns;
  };
  for (const double time_s : times_s)
    if (positions.time.empty() || positions.time.back().ns < since_first_ns(time_s)) {
      positions.frame.push_back(std::ssize(positions.frame));
      positions.time.push_back({since_first_ns(time_s)});
    }
  positions.position_m.assign(
      joints.size(), std::vector<Eigen::Vector3d>(positions.time.size(), Eigen::Vector3d::Constant(kNaN)));
  std::size_t frame = 0;
  for (const Row& row : rows) {
    while (positions.time[frame].ns < since_first_ns(row.time_s)) ++frame;
    Eigen::Vector3d& position_m = positions.position_m[row.joint][frame];
    if (position_m.allFinite() && row.position_m.allFinite())
      throw InputError(path.string(),
                       fmt::format("has {} twice at {:.6f} s; the joints of one person are wanted",
                                   positions.header.assets[row.joint].name, row.time_s * unit_s));
    if (!position_m.allFinite()) position_m = row.position_m;
  }
  positions.missing = remove_missing(positions.time, positions.position_m);
  return positions;
}

}  // namespace trilat
