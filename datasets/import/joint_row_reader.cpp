// SPDX-License-Identifier: MIT
#include "datasets/import/joint_row_reader.h"

#include <limits>

#include <fmt/format.h>

#include "datasets/import/import_types.h"
#include "datasets/import/joint_cells.h"

namespace trilat {
namespace {

std::int64_t ticks_in(std::string_view cell, const JointRowFormat& format) {
  const std::int64_t time = integer_in(cell, fmt::format("the time in {}", format.time_unit));
  const std::int64_t limit = std::numeric_limits<std::int64_t>::max() / format.ticks_per_unit;
  if (time < -limit || time > limit)
    throw TornRow{fmt::format("has the time {}, which is beyond all clocks", time)};
  return time * format.ticks_per_unit;
}

}  // namespace

const JointRowFormat kLabanotationRows{comma_cells, "ticks", 1, true};
const JointRowFormat kUmonsTaichiRows{blank_cells, "whole milliseconds", 10'000, false};

JointRowReader::JointRowReader(const std::filesystem::path& path, const JointRowFormat& format)
    : format_(format), lines_(path, 1u << 16) {}

bool JointRowReader::next(FileFrame& frame) {
  frame = {};
  std::string_view line;
  std::vector<std::string_view> cells;
  while (cells.empty()) {
    if (!lines_.next(line)) return false;
    bytes_ += line.size() + 1;
    cells = format_.cells_of(line);
  }
  const std::size_t cells_of_a_joint = format_.has_states ? 4 : 3;
  const std::size_t expected = 1 + cells_of_a_joint * kJointCount;
  if (cells.size() != expected)
    throw TornRow{fmt::format("has {} cells; a row has {}: the time, then x, y, z{} of 25 joints",
                              cells.size(), expected, format_.has_states ? " and state" : "")};
  frame.ticks = ticks_in(cells[0], format_);
  Body& body = frame.bodies.emplace_back();
  body.tracking_id = 1;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const std::string_view* joint = &cells[1 + cells_of_a_joint * j];
    for (std::size_t axis = 0; axis < 3; ++axis)
      body.position_m[j][axis] = static_cast<float>(number_in(joint[axis], "a joint's position"));
    body.tracking_state[j] =
        format_.has_states ? tracking_state_of(number_in(joint[3], "a tracking state"), place()) : 2;
  }
  return true;
}

}  // namespace trilat
