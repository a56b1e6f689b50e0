// SPDX-License-Identifier: MIT
#include "datasets/import/labanotation_reader.h"

#include <fmt/format.h>

#include "datasets/import/import_types.h"
#include "datasets/import/joint_cells.h"

namespace trilat {
namespace {

constexpr std::size_t kCellsOfAFrame = 1 + 4 * std::size_t{kJointCount};

}  // namespace

LabanotationReader::LabanotationReader(const std::filesystem::path& path) : lines_(path, 1u << 16) {}

bool LabanotationReader::next(FileFrame& frame) {
  frame = {};
  std::string_view line;
  std::vector<std::string_view> cells;
  while (cells.empty()) {
    if (!lines_.next(line)) return false;
    bytes_ += line.size() + 1;
    cells = comma_cells(line);
  }
  if (cells.size() != kCellsOfAFrame)
    throw TornRow{fmt::format("has {} cells; a row has {}: the time, then x, y, z and state of 25 joints",
                              cells.size(), kCellsOfAFrame)};
  frame.ticks = integer_in(cells[0], "the time in ticks");
  Body& body = frame.bodies.emplace_back();
  body.tracking_id = 1;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const std::string_view* joint = &cells[1 + 4 * j];
    for (std::size_t axis = 0; axis < 3; ++axis)
      body.position_m[j][axis] = static_cast<float>(number_in(joint[axis], "a joint's position"));
    body.tracking_state[j] = tracking_state_of(number_in(joint[3], "a tracking state"), place());
  }
  return true;
}

}  // namespace trilat
