// SPDX-License-Identifier: MIT
#include "datasets/import/ntu_reader.h"

#include <cctype>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/import/import_types.h"
#include "datasets/import/joint_cells.h"
#include "datasets/mocap/csv_cell.h"

namespace trilat {
namespace {

constexpr std::int64_t kMostFrames = 100'000'000;
constexpr std::int64_t kMostBodiesOfAFile =
    64;  // more than a session takes, so that a frame with 7 is only torn
constexpr std::size_t kCellsOfABody = 10;
constexpr std::size_t kCellsOfAJoint = 12;

void need_cells(const std::vector<std::string_view>& cells, std::size_t count, std::string_view what) {
  if (cells.size() != count) throw TornRow{fmt::format("has {} cells; {} has {}", cells.size(), what, count)};
}

void read_body_line(std::string_view line, Body& body) {
  const auto cells = blank_cells(line);
  need_cells(cells, kCellsOfABody, "the line about a body");
  body.tracking_id = id_in(cells[0], "a body's id");
  for (std::size_t hand = 0; hand < 2; ++hand) {
    body.hand_confidence[hand] = small_number_in(cells[2 + 2 * hand], "a hand's confidence", 1);
    body.hand_state[hand] = small_number_in(cells[3 + 2 * hand], "a hand's state", 4);
  }
}

// What the SDK could not project is infinite or NaN; then it is outside of any image.
double pixel_in(std::string_view cell) {
  double px = 0.0;
  const CellKind kind = parse_cell(cell, px);
  return kind == CellKind::number ? px : kind == CellKind::not_finite ? -1.0 : number_in(cell, "a pixel");
}

void read_joint_line(std::string_view line, std::size_t j, Body& body, JointPixels& depth_px,
                     const std::string& place) {
  const auto cells = blank_cells(line);
  need_cells(cells, kCellsOfAJoint, "the line of a joint");
  for (std::size_t axis = 0; axis < 3; ++axis)
    body.position_m[j][axis] = static_cast<float>(number_in(cells[axis], "a joint's position"));
  for (std::size_t axis = 0; axis < 2; ++axis) depth_px[j][axis] = pixel_in(cells[3 + axis]);
  body.orientation_xyzw[j][3] = static_cast<float>(number_in(cells[7], "an orientation"));
  for (std::size_t axis = 0; axis < 3; ++axis)
    body.orientation_xyzw[j][axis] = static_cast<float>(number_in(cells[8 + axis], "an orientation"));
  body.tracking_state[j] = tracking_state_of(number_in(cells[11], "a tracking state"), place);
}

bool is_numbered(const std::string& stem, std::size_t at, char letter) {
  if (stem[at] != letter) return false;
  for (std::size_t i = at + 1; i < at + 4; ++i)
    if (!std::isdigit(static_cast<unsigned char>(stem[i]))) return false;
  return true;
}

}  // namespace

NtuReader::NtuReader(const std::filesystem::path& path, double rate_hz)
    : lines_(path, 1u << 16), rate_hz_(rate_hz) {
  try {
    frames_ = count_line("the number of frames", kMostFrames);
  } catch (const TornRow& row) {
    throw InputError(place(), row.problem + "; this is no .skeleton file");
  }
}

bool NtuReader::next_line(std::string_view& line) {
  if (!lines_.next(line)) return false;
  bytes_ += line.size() + 1;
  return true;
}

// A line that is one number. Where it is anything else the rest of the file cannot be told apart.
std::int64_t NtuReader::count_line(std::string_view what, std::int64_t limit) {
  std::string_view line;
  if (!next_line(line)) throw TornRow{fmt::format("is where the file ends, before {}", what)};
  const auto cells = blank_cells(line);
  need_cells(cells, 1, what);
  const std::int64_t count = integer_in(cells[0], what);
  if (count < 0 || count > limit) throw TornRow{fmt::format("has {} as {}", count, what)};
  return count;
}

// A line that cannot be read goes to `problem`; the lines behind it are read all the same.
void NtuReader::read_body(FileFrame& frame, std::string& problem) {
  Body& body = frame.bodies.emplace_back();
  JointPixels& depth_px = frame.depth_px.emplace_back();
  const auto attempt = [&](const auto& read) {
    std::string_view line;
    if (!next_line(line)) throw TornRow{"is where the file ends, within a frame"};
    try {
      read(line);
    } catch (const TornRow& row) {
      if (problem.empty()) problem = row.problem;
    }
  };
  attempt([&](std::string_view line) { read_body_line(line, body); });
  if (count_line("the number of joints", kJointCount) != kJointCount)
    throw TornRow{"has another number of joints than 25"};
  for (std::size_t j = 0; j < kJointCount; ++j)
    attempt([&](std::string_view line) { read_joint_line(line, j, body, depth_px, place()); });
}

bool NtuReader::next(FileFrame& frame) {
  frame = {};
  if (frame_ >= frames_) return false;
  frame.sequence = frame_;
  frame.ticks =
      std::llround(1e9 / static_cast<double>(kImportTickNs) * static_cast<double>(frame_) / rate_hz_);
  std::string problem;
  try {
    const std::int64_t bodies = count_line("the number of bodies", kMostBodiesOfAFile);
    for (std::int64_t b = 0; b < bodies; ++b) read_body(frame, problem);
  } catch (const TornRow& row) {
    const std::int64_t left = frames_ - frame_;
    frame_ = frames_;
    throw TornRow{fmt::format("{}; nothing behind it can be read, {} of {} frames are lost", row.problem,
                              left, frames_)};
  }
  ++frame_;
  if (!problem.empty()) throw TornRow{problem};
  return true;
}

std::optional<NtuName> ntu_name_of(const std::filesystem::path& path) {
  const std::string stem = path.stem().string();
  if (stem.size() != 20) return {};
  const std::string letters = "SCPRA";
  for (std::size_t i = 0; i < letters.size(); ++i)
    if (!is_numbered(stem, 4 * i, letters[i])) return {};
  return NtuName{stem.substr(4, 4), stem.substr(0, 4) + stem.substr(8)};
}

}  // namespace trilat
