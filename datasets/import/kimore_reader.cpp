// SPDX-License-Identifier: MIT
#include "datasets/import/kimore_reader.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/import/import_types.h"
#include "datasets/import/joint_cells.h"

namespace trilat {
namespace {

constexpr std::size_t kBlockBytes = 1u << 16;
constexpr std::size_t kCellsOfARow = 4 * std::size_t{kJointCount};

std::filesystem::path the_one(const std::filesystem::path& folder, const std::string& prefix, bool needed) {
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(prefix) && name.ends_with(".csv")) found.push_back(entry.path());
  }
  if (found.size() > 1 || (needed && found.empty()))
    throw InputError(
        folder.string(),
        fmt::format("holds {} files {}*.csv; the files of one exercise are expected", found.size(), prefix));
  return found.empty() ? std::filesystem::path() : found.front();
}

void need_row(const std::vector<std::string_view>& cells) {
  if (cells.size() != kCellsOfARow)
    throw TornRow{
        fmt::format("has {} cells; a row has {}: four for each of 25 joints", cells.size(), kCellsOfARow)};
}

std::int64_t time_in(std::string_view line) {
  const auto times = comma_cells(line);
  if (times.size() != 1) throw TornRow{fmt::format("has {} times beside it instead of one", times.size())};
  return integer_in(times[0], "the time in ticks");
}

}  // namespace

KimoreFiles kimore_files_of(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return {path, {}, {}};
  return {the_one(path, "JointPosition", true), the_one(path, "TimeStamp", false),
          the_one(path, "JointOrientation", false)};
}

KimoreReader::KimoreReader(const KimoreFiles& files, double rate_hz)
    : positions_(files.position, kBlockBytes), rate_hz_(rate_hz) {
  if (!files.time.empty()) times_ = std::make_unique<LineReader>(files.time, kBlockBytes);
  if (!files.orientation.empty())
    orientations_ = std::make_unique<LineReader>(files.orientation, kBlockBytes);
}

// The next row that is not blank: the recorder writes an empty line before each file's first.
bool KimoreReader::next_row(LineReader& lines, std::string_view& line) {
  do {
    if (!lines.next(line)) return false;
    bytes_ += line.size() + 1;
  } while (line.find_first_not_of(" \t,\r") == std::string_view::npos);
  return true;
}

// All files go on by one row before any is read, so that a torn row costs one frame.
bool KimoreReader::next(FileFrame& frame) {
  frame = {};
  std::string_view position, time, orientation;
  const bool has_position = next_row(positions_, position);
  const bool has_time = !times_ || next_row(*times_, time);
  const bool has_orientation = !orientations_ || next_row(*orientations_, orientation);
  if (!has_position && (!times_ || !has_time) && (!orientations_ || !has_orientation)) return false;
  const std::int64_t row = rows_++;
  if (!has_position || !has_time || !has_orientation)
    throw TornRow{"is where one of the files has ended and another has not"};
  frame.ticks =
      times_ ? time_in(time)
             : std::llround(1e9 / (rate_hz_ * static_cast<double>(kImportTickNs)) * static_cast<double>(row));
  const auto cells = comma_cells(position);
  need_row(cells);
  Body& body = frame.bodies.emplace_back();
  body.tracking_id = 1;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      body.position_m[j][axis] = static_cast<float>(number_in(cells[4 * j + axis], "a joint's position"));
    body.tracking_state[j] = tracking_state_of(number_in(cells[4 * j + 3], "a tracking state"), place());
  }
  if (!orientations_) return true;
  const auto turns = comma_cells(orientation);
  need_row(turns);
  for (std::size_t i = 0; i < kCellsOfARow; ++i)
    body.orientation_xyzw[i / 4][i % 4] = static_cast<float>(number_in(turns[i], "an orientation"));
  return true;
}

}  // namespace trilat
