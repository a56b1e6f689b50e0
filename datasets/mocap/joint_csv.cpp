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
  std::vector<std::string> names = split_csv(line);
  if (joint_columns(names)[0] < names.size()) refuse_lone_returns(line, lines.place());
  return names;
}

// The unit of a file's times, in seconds: one, unless the rate would then be none of a camera; milliseconds,
// micro- or nanoseconds whose rate is one. InputError for others.
double unit_of(const std::vector<double>& times, const std::string& place,
               std::vector<std::string>& taken_as) {
  constexpr double kMinRate_hz = 0.5, kMinCamera_hz = 5.0, kMaxCamera_hz = 1000.0;
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  const double step = steps.empty() ? 1.0 : upper_median(steps);
  if (step == 1.0 && std::ranges::all_of(times, [](double time) { return time == std::round(time); }) &&
      times.size() > 2)
    taken_as.emplace_back(
        "time_s counts by 1, as frame numbers do, and is taken as seconds; if it counts frames, divide it by "
        "the frame rate");
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

struct JointRow {
  double time_s;  // in the file's unit
  std::size_t joint;
  Eigen::Vector3d position_m;
  std::size_t number;  // of the row in the file, from 0
};

// The rows of a file of joints, whose names become the assets of a take.
class JointRows {
 public:
  JointRows(const std::filesystem::path& path, MocapTake& take)
      : lines_(path, kReadBytes), take_(take), names_(column_names(lines_)), places_(joint_columns(names_)) {
    for (std::size_t c = 0; c < places_.size(); ++c)
      if (places_[c] == names_.size())
        throw InputError(lines_.place(),
                         fmt::format("has no column {} among {}; needed are {}", kJointColumns[c],
                                     fmt::join(names_, ", "), fmt::join(kJointColumns, ", ")));
  }
  // In the order of time.
  std::vector<JointRow> read() {
    std::vector<JointRow> rows;
    for (std::string_view line; lines_.next(line);) {
      cells_ = split_csv(line);
      const bool is_short = cells_.size() < names_.size();
      if (is_short && !lines_.terminated()) take_.anomalies.truncated_last_row = true;
      if (is_short && (line.empty() || !lines_.terminated())) continue;
      if (cells_.size() != names_.size())
        throw InputError(lines_.place(),
                         fmt::format("has {} cells under {} columns", cells_.size(), names_.size()));
      rows.push_back({time(), joint(), position_m(), rows.size()});
    }
    far_.end();
    std::ranges::stable_sort(rows, {}, &JointRow::time_s);
    return rows;
  }

 private:
  const std::string& cell(std::size_t column) const { return cells_[places_[column]]; }
  double number(std::size_t column) const {
    double value = kNaN;
    const CellKind kind = parse_cell(cell(column), value);
    if (kind == CellKind::unreadable)
      throw InputError(
          lines_.place(),
          fmt::format("{} is \"{}\", which is not a number; {}", kJointColumns[column], cell(column),
                      column == 0 ? "times are seconds, such as 0.033" : "what is missing is left empty"));
    return kind == CellKind::number ? value : kNaN;
  }
  double time() const {
    const double time_s = number(0);
    if (!std::isfinite(time_s)) throw InputError(lines_.place(), "has no time_s");
    return time_s;
  }
  std::size_t joint() {
    const auto [joint, is_new] = joints_.try_emplace(cell(1), joints_.size());
    if (is_new) take_.header.assets.push_back({AssetType::marker, joint->first, "", "", true});
    return joint->second;
  }
  Eigen::Vector3d position_m() {
    Eigen::Vector3d position_m(number(2), number(3), number(4));
    if (!position_m.allFinite()) position_m.setConstant(kNaN);
    for (const double x_m : position_m)
      if (std::abs(x_m) > kMaxDistance_m)
        far_.add(x_m, [&] { return InputError(lines_.place(), cell(1) + ' ' + kTooFar); });
    if (position_m.cwiseAbs().maxCoeff() > kMaxDistance_m) position_m.setConstant(kFilled);
    return position_m;
  }

  LineReader lines_;
  MocapTake& take_;
  std::vector<std::string> names_;
  std::array<std::size_t, kJointColumns.size()> places_;
  std::vector<std::string> cells_;  // of the row that was read last
  std::map<std::string, std::size_t> joints_;
  FarNumbers far_;
};

// Sets the take's frames, one a time, and returns the unit of the times in seconds.
double set_times(const std::vector<JointRow>& rows, const std::string& place, MocapTake& take) {
  std::vector<double> times;
  for (const JointRow& row : rows)
    if (times.empty() || times.back() < row.time_s) times.push_back(row.time_s);
  const double unit_s = unit_of(times, place, take.taken_as);
  take.first_s = times.front() * unit_s;
  const double latest_s = std::max(
      {std::abs(take.first_s), std::abs(times.back() * unit_s), (times.back() - times.front()) * unit_s});
  if (!(latest_s <= kLatestCsv_s))
    throw InputError(place, fmt::format("has a time_s of {:g}, which no clock shows", times.back()));
  for (const double time : times) {
    const MocapTime since_first{duration_from_s((time - times.front()) * unit_s).ns};
    if (!take.time.empty() && take.time.back() >= since_first) continue;
    take.frame.push_back(std::ssize(take.frame));
    take.time.push_back(since_first);
  }
  return unit_s;
}

// Throws InputError for two rows of one joint at one time, with what the file seems to be. `rows` are in the
// order of time.
[[noreturn]] void refuse_twice(const std::vector<JointRow>& rows, const JointRow& later,
                               const std::string& name, const std::string& path, double unit_s) {
  const auto is_before = [&](const JointRow& row) {
    return row.joint == later.joint && row.number < later.number;
  };
  const JointRow *same = nullptr, *before = nullptr;  // in the order of the file
  for (const JointRow& row : rows) {
    if (!is_before(row)) continue;
    if (row.time_s == later.time_s) same = &row;
    if (!before || row.number > before->number) before = &row;
  }
  const std::string what = fmt::format("has {} twice at {:.6f} s", name, later.time_s * unit_s);
  if (before && before->time_s > later.time_s)
    throw InputError(path, fmt::format("{}: its times go back there from {:.6f} s, as where two recordings "
                                       "or persons were joined, or a clock was set back; give each as a file "
                                       "of its own",
                                       what, before->time_s * unit_s));
  if (same && same->position_m == later.position_m)
    throw InputError(path, what + ", with one position: rows stand there twice; write each once");
  throw InputError(path, what + "; the joints of one person are wanted");
}

}  // namespace

bool is_joint_csv(const std::filesystem::path& path) {
  LineReader lines(path, kReadBytes);
  const std::vector<std::string> names = column_names(lines);
  const auto places = joint_columns(names);
  return places[0] < names.size() && places[1] < names.size();
}

MocapTake read_joint_csv(const std::filesystem::path& path) {
  MocapTake take;
  take.header.format = "joints as CSV";
  const std::vector<JointRow> rows = JointRows(path, take).read();
  if (rows.empty()) throw InputError(path.string(), "holds no joints");
  const double unit_s = set_times(rows, path.string(), take);
  take.position_m.assign(take.header.assets.size(),
                         std::vector<Eigen::Vector3d>(take.time.size(), Eigen::Vector3d::Constant(kNaN)));
  std::size_t frame = 0;
  for (const JointRow& row : rows) {
    const std::int64_t since_first_ns = duration_from_s((row.time_s - rows.front().time_s) * unit_s).ns;
    while (take.time[frame].ns < since_first_ns) ++frame;
    Eigen::Vector3d& position_m = take.position_m[row.joint][frame];
    if (position_m.allFinite() && row.position_m.allFinite())
      refuse_twice(rows, row, take.header.assets[row.joint].name, path.string(), unit_s);
    if (!position_m.allFinite()) position_m = row.position_m;
  }
  take.missing = remove_missing(take.time, take.position_m);
  return take;
}

}  // namespace trilat
