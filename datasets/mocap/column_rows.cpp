// SPDX-License-Identifier: MIT
#include "datasets/mocap/column_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/mocap/csv_cell.h"

namespace trilat {
namespace {

bool is_blank(std::string_view line) { return line.find_first_not_of(", \t\"") == std::string_view::npos; }

std::size_t count_fields(std::string_view line) {
  return static_cast<std::size_t>(std::ranges::count(line, ',')) + 1;
}

}  // namespace

ColumnRows::ColumnRows(LineReader& lines, MocapHeader& header, ColumnLayout layout)
    : lines_(lines), header_(header), layout_(std::move(layout)) {
  metres_ = metres_per(header.length_unit);
  if (!std::isnan(header.export_rate_hz)) rate_uhz_ = std::llround(header.export_rate_hz * 1e6);
  std::vector<std::size_t> all(header.assets.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  read_only(all);
  std::string_view line;
  if (!next_row(line)) return;
  if (lines_.terminated() || count_fields(line) >= layout_.used_columns)
    header.first_frame = read_index(line);
  lines_.unread();
  rows_ = 0;
}

bool ColumnRows::next_row(std::string_view& line) {
  while (lines_.next(line)) {
    if (layout_.tab_separated && !line.empty()) line = with_commas(line);
    if (is_blank(line)) continue;
    ++rows_;
    return true;
  }
  return false;
}

std::string_view ColumnRows::with_commas(std::string_view line) {
  if (line.find(',') != std::string_view::npos)
    throw InputError(lines_.place(),
                     "the row has a comma; numbers are written with a decimal point, and tabs stand between");
  text_ = line;
  std::ranges::replace(text_, '\t', ',');
  return text_;
}

// A Motive header may promise more than was exported; a TRC that ends early has been cut.
void ColumnRows::check_promise(MocapAnomalies& anomalies) const {
  const std::int64_t promised = header_.total_exported_frames.value_or(0);
  if (rows_ >= promised) return;
  if (layout_.tab_separated)
    throw InputError(lines_.place(), "the file ends after " + std::to_string(rows_) +
                                         " frames; its header promises " + std::to_string(promised));
  anomalies.frames_promised = promised;
  anomalies.frames_there = rows_;
}

// A file that was put together goes back once or twice; more often, its rows were shuffled.
void ColumnRows::check_order() const {
  constexpr std::int64_t kMaxSteps = 3, kRowsOfStep = 50;
  if (steps_back_ > kMaxSteps && steps_back_ * kRowsOfStep > rows_)
    throw InputError(lines_.place(), std::to_string(steps_back_) + " of " + std::to_string(rows_) +
                                         " rows stand behind rows of later frames; sort the rows by frame");
}

void ColumnRows::check_times(const MocapAnomalies& anomalies) const {
  constexpr std::int64_t kMinRows = 10;
  if (rows_ < kMinRows || 2 * anomalies.printed_time_differs <= rows_) return;
  const double rate_hz =
      static_cast<double>(last_index_ - first_index_) / (last_printed_s_ - first_printed_s_);
  throw InputError(
      lines_.place(),
      fmt::format("the times of {} of {} rows are more than a frame off what frame number and rate "
                  "give: by the times the rate is {:.6g} Hz, and the header states {:.6g} Hz",
                  anomalies.printed_time_differs, rows_, rate_hz, header_.export_rate_hz));
}

// A spreadsheet or script of another locale writes 0,02 for 0.02: then a row has nearly twice the cells.
void ColumnRows::check_decimal_comma(std::string_view line) const {
  std::size_t written = 0;
  for (std::size_t begin = 0; begin < line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    written += end > begin;
    begin = end + 1;
  }
  constexpr double kTimes = 1.4;
  if (line.find('.') == std::string_view::npos &&
      static_cast<double>(written) > kTimes * static_cast<double>(layout_.used_columns))
    throw InputError(lines_.place(), "the row has " + std::to_string(written) + " numbers for " +
                                         std::to_string(layout_.used_columns) +
                                         " columns and no decimal point: it seems to be written with a "
                                         "decimal comma; save the file with decimal points");
}

void ColumnRows::read_only(const std::vector<std::size_t>& assets) {
  assets_ = assets;
  numbers_.assign(kSlotsPerAsset * assets.size() + 1, kMissing);
  target_.assign(layout_.used_columns, kNoColumn);
  target_[layout_.time_column] = numbers_.size() - 1;
  std::size_t last = layout_.time_column;
  for (std::size_t i = 0; i < assets.size(); ++i)
    for (std::size_t slot = 0; slot < kSlotsPerAsset; ++slot) {
      const std::size_t column = layout_.columns.at(assets[i])[slot];
      if (column == kNoColumn) continue;
      target_[column] = kSlotsPerAsset * i + slot;
      last = std::max(last, column);
    }
  target_.resize(last + 1);
}

bool ColumnRows::next(MocapFrame& frame, MocapAnomalies& anomalies) {
  std::string_view line;
  while (next_row(line)) {
    const bool is_short = count_fields(line) < layout_.used_columns;
    // A whole row that the header promised needs no line end.
    if (!lines_.terminated() && (is_short || !layout_.tab_separated)) {
      anomalies.truncated_last_row = true;
      rows_ -= is_short;
      if (is_short) break;
      // Its last number may lack digits.
      line = line.substr(0, line.rfind(',') + 1);
    }
    if (read_row(line, frame, anomalies)) return true;
  }
  far_.end();
  check_order();
  check_times(anomalies);
  check_promise(anomalies);
  return false;
}

bool ColumnRows::read_row(std::string_view line, MocapFrame& frame, MocapAnomalies& anomalies) {
  const std::int64_t index = read_index(line);
  std::ranges::fill(numbers_, kMissing);
  not_finite_cells_ = 0;
  const char* const end = line.data() + line.size();
  std::size_t fields = 1;
  const char* const p = read_cells(end_of_cell(line.data(), end), end, fields);
  fields += static_cast<std::size_t>(std::count(p, end, ','));
  if (fields > layout_.written_columns) {
    check_decimal_comma(line);
    ++anomalies.rows_with_extra_fields;
  }
  frame.index = index;
  frame.printed_time_s = numbers_.back();
  if (!set_time(frame, anomalies)) return false;
  anomalies.not_finite_cells += not_finite_cells_;
  frame.poses.assign(header_.assets.size(), MocapPose());
  for (std::size_t i = 0; i < assets_.size(); ++i) set_pose(i, frame.poses[assets_[i]], anomalies);
  return true;
}

std::int64_t ColumnRows::read_index(std::string_view line) const {
  const auto cell = line.substr(
      0, static_cast<std::size_t>(end_of_cell(line.data(), line.data() + line.size()) - line.data()));
  std::int64_t index = 0;
  if (!parse_integer(cell, index)) refuse_cell(0, cell, "is not a frame number");
  if (std::abs(index) > kHighestFrame) refuse_cell(0, cell, "is too large for a frame number");
  return index;
}

// Stands at the comma before each cell; ends behind the last wanted one.
const char* ColumnRows::read_cells(const char* p, const char* end, std::size_t& fields) {
  for (std::size_t column = 1; column < target_.size() && p != end; ++column) {
    ++p;
    ++fields;
    p = target_[column] == kNoColumn ? end_of_cell(p, end) : read_number(p, end, column);
  }
  return p;
}

const char* ColumnRows::read_number(const char* p, const char* end, std::size_t column) {
  if (p == end || *p == ',') return p;
  double& number = numbers_[target_[column]];
  if (const char* const behind = parse_plain_decimal(p, end, number)) return behind;
  const char* const behind = end_of_cell(p, end);
  const std::string_view cell(p, static_cast<std::size_t>(behind - p));
  number = kMissing;
  switch (parse_cell(cell, number)) {
    case CellKind::number:
      break;
    case CellKind::empty:
      break;
    case CellKind::not_finite:
      number = kMissing;
      ++not_finite_cells_;
      break;
    case CellKind::unreadable:
      refuse_cell(column, cell, "is not a number");
  }
  return behind;
}

bool ColumnRows::set_time(MocapFrame& frame, MocapAnomalies& anomalies) {
  const double printed_s = frame.printed_time_s;
  if (std::abs(printed_s) > kLatest_s)
    refuse_cell(layout_.time_column, std::to_string(printed_s), "is not a time within a take");
  if (rate_uhz_ == 0 && std::isnan(printed_s))
    throw InputError(lines_.place(),
                     "the row has no time, and the header states no frame rate to make it from");
  if (!started_) {
    first_printed_s_ = printed_s;
    first_index_ = previous_index_ = frame.index;
  }
  steps_back_ += frame.index < previous_index_ ? 1 : 0;
  previous_index_ = frame.index;
  const bool advances =
      !started_ || (frame.index > last_index_ && (rate_uhz_ != 0 || printed_s > last_printed_s_));
  if (!advances) {
    ++anomalies.repeated_frames;
    return false;
  }
  started_ = true;
  last_index_ = frame.index;
  last_printed_s_ = printed_s;
  const double since_s = printed_s - first_printed_s_;
  const Duration printed = duration_from_s(std::isnan(since_s) ? 0.0 : since_s);
  if (rate_uhz_ == 0) {
    frame.time = MocapTime{} + printed;
    return true;
  }
  frame.time = MocapTime{} + duration_of_frames(frame.index - header_.first_frame, rate_uhz_);
  if (!std::isnan(since_s) &&
      std::abs((printed - (frame.time - MocapTime{})).ns) > duration_of_frames(1, rate_uhz_).ns)
    ++anomalies.printed_time_differs;
  return true;
}

void ColumnRows::set_pose(std::size_t number, MocapPose& pose, MocapAnomalies& anomalies) {
  const double* const position = &numbers_[kSlotsPerAsset * number];
  pose.position_m = metres_ * Eigen::Vector3d(position[0], position[1], position[2]);
  bool is_filled = false;
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(pose.position_m[axis]) > kMaxDistance_m) {
      is_filled = true;
      far_.add(position[axis], [&] {
        return cell_refusal(layout_.columns[assets_[number]][static_cast<std::size_t>(axis)],
                            std::to_string(position[axis]) + " " + std::string(name_of(header_.length_unit)),
                            kTooFar);
      });
    }
  if (is_filled) {
    pose.position_m.setConstant(kFilled);
    return;
  }
  if (pose.position_m.hasNaN()) {
    if (!pose.position_m.array().isNaN().all()) ++anomalies.partial_poses;
    pose.position_m.setConstant(kMissing);
  }
}

void ColumnRows::refuse_cell(std::size_t column, std::string_view cell, const char* problem) const {
  throw cell_refusal(column, cell, problem);
}

InputError ColumnRows::cell_refusal(std::size_t column, std::string_view cell, const char* problem) const {
  std::string who = column == 0 ? "frame" : column == layout_.time_column ? "time" : "";
  for (std::size_t i = 0; who.empty() && i < layout_.columns.size(); ++i)
    for (std::size_t slot = 0; slot < kSlotsPerAsset; ++slot)
      if (layout_.columns[i][slot] == column) who = key_of(header_, i) + ", " + std::string(kSlotNames[slot]);
  return {lines_.place(), "column " + std::to_string(column + 1) + " (" + who + "): \"" +
                              std::string(cell.substr(0, 40)) + "\" " + problem};
}

}  // namespace trilat
