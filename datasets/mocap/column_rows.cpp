// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/mocap/column_header.h"

namespace trilat {
namespace {

bool is_blank(std::string_view line) { return line.find_first_not_of(", \t\"") == std::string_view::npos; }

std::size_t count_fields(std::string_view line) {
  return static_cast<std::size_t>(std::ranges::count(line, ',')) + 1;
}

// Names the unit of printed times that run so many times as fast as the frames; empty where no unit fits.
std::string time_unit_text(double times_as_fast, double rate_hz) {
  constexpr double kDiffers = 0.02;
  const std::pair<double, const char*> units[] = {
      {1e3, "milliseconds"}, {1e6, "microseconds"}, {1e9, "nanoseconds"}};
  for (const auto& [per_second, name] : units)
    if (std::abs(times_as_fast / per_second - 1.0) < kDiffers)
      return fmt::format(". As {} both agree: divide the times by {:g}", name, per_second);
  if (std::abs(times_as_fast / rate_hz - 1.0) < kDiffers)
    return ". As frame numbers both agree: divide the times by the rate";
  return "";
}

class RowReader {
 public:
  RowReader(LineReader& lines, const ColumnLayout& layout, const std::vector<std::size_t>& assets,
            MocapTake& take);
  void read(MocapTime until);

 private:
  // The next row that is not blank, with commas between its cells, a frame number and a time.
  bool next_row(std::string_view& line);
  std::string_view with_commas(std::string_view line);
  void check_promise();
  void check_order() const;
  void check_times();
  void check_decimal_comma(std::string_view line) const;
  void read_row(std::string_view line);
  std::int64_t read_index(std::string_view line) const;
  const char* read_cells(const char* p, const char* end, std::size_t& fields);
  const char* read_number(const char* p, const char* end, std::size_t column);
  bool add_time(std::int64_t index, double printed_s);
  Eigen::Vector3d position(std::size_t number);
  [[noreturn]] void refuse_cell(std::size_t column, std::string_view cell, const char* problem) const;
  InputError cell_refusal(std::size_t column, std::string_view cell, const char* problem) const;

  LineReader& lines_;
  const ColumnLayout& layout_;
  const std::vector<std::size_t>& assets_;
  MocapTake& take_;
  const MocapHeader& header_ = take_.header;
  MocapAnomalies& anomalies_ = take_.anomalies;
  std::vector<std::size_t> target_;  // of each column in numbers_; kNoColumn to skip it
  std::vector<double> numbers_;      // of one row: kSlotsPerAsset an asset, and the printed time
  std::int64_t not_finite_cells_ = 0;
  double metres_ = 1.0;
  std::int64_t rate_uhz_ = 0;        // 0: not stated
  std::string text_;                 // of a row that had tabs
  std::int64_t rows_ = 0;            // read so far
  std::int64_t previous_index_ = 0;  // of the row before
  std::int64_t first_missing_ = 0;   // frame that the rows leave out; 0: none
  std::int64_t repeated_times_ = 0;  // rows with the printed time of the row before
  std::int64_t steps_back_ = 0;      // rows whose frame is before that of the row before
  double first_printed_s_ = kNaN, last_printed_s_ = kNaN;  // of rows that were taken
  double zero_printed_s_ = kNaN;          // printed time of the first frame, from the first row that has one
  double min_printed_step_s_ = HUGE_VAL;  // between rows whose printed times differ
  FarNumbers far_;
};

RowReader::RowReader(LineReader& lines, const ColumnLayout& layout, const std::vector<std::size_t>& assets,
                     MocapTake& take)
    : lines_(lines), layout_(layout), assets_(assets), take_(take) {
  metres_ = metres_per(header_.length_unit);
  if (!std::isnan(header_.export_rate_hz)) rate_uhz_ = std::llround(header_.export_rate_hz * 1e6);
  numbers_.assign(kSlotsPerAsset * assets.size() + 1, kNaN);
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

bool RowReader::next_row(std::string_view& line) {
  while (lines_.next(line)) {
    if (layout_.tab_separated && !line.empty()) line = with_commas(line);
    if (is_blank(line)) continue;
    ++rows_;
    return true;
  }
  return false;
}

std::string_view RowReader::with_commas(std::string_view line) {
  if (line.find(',') != std::string_view::npos)
    throw InputError(lines_.place(),
                     "the row has a comma; numbers are written with a decimal point, and tabs stand between");
  text_ = line;
  std::ranges::replace(text_, '\t', ',');
  return text_;
}

// A Motive header may promise more than was exported; a TRC that ends early has been cut.
void RowReader::check_promise() {
  const std::int64_t promised = header_.total_exported_frames.value_or(0);
  if (rows_ >= promised) return;
  if (layout_.tab_separated && previous_index_ - header_.first_frame + 1 == promised)
    throw InputError(lines_.place(),
                     fmt::format("has {} of the {} frames that its header promises; the first "
                                 "that is missing is {}. Write the count that is there, or "
                                 "rows without positions",
                                 rows_, promised, first_missing_));
  if (layout_.tab_separated)
    throw InputError(lines_.place(), "the file ends after " + std::to_string(rows_) +
                                         " frames; its header promises " + std::to_string(promised));
  anomalies_.frames_promised = promised;
  anomalies_.frames_there = rows_;
}

// A file that was put together goes back once or twice; more often, its rows were shuffled.
void RowReader::check_order() const {
  constexpr std::int64_t kMaxSteps = 3, kRowsOfStep = 50;
  if (steps_back_ > kMaxSteps && steps_back_ * kRowsOfStep > rows_)
    throw InputError(lines_.place(), std::to_string(steps_back_) + " of " + std::to_string(rows_) +
                                         " rows stand behind rows of later frames; sort the rows by frame");
}

void RowReader::check_times() {
  constexpr std::int64_t kMinRows = 10;
  const bool advance = last_printed_s_ > first_printed_s_;
  if (rows_ < kMinRows) return;
  // rounded to steps of some frames, which then share a time
  if (advance && 4 * repeated_times_ >= rows_ && anomalies_.largest_time_error_s <= min_printed_step_s_)
    anomalies_.printed_time_differs = 0;
  if (2 * anomalies_.printed_time_differs <= rows_) return;
  if (!advance)
    throw InputError(lines_.place(),
                     fmt::format("the times of all rows are {:g}; write frame / rate, or leave "
                                 "them empty: the header states {:.6g} Hz",
                                 first_printed_s_, header_.export_rate_hz));
  const double rate_hz =
      static_cast<double>(take_.frame.back() - take_.frame.front()) / (last_printed_s_ - first_printed_s_);
  throw InputError(
      lines_.place(),
      fmt::format("the times of {} of {} rows are more than a frame off what frame number and rate "
                  "give: by the times the rate is {:.6g} Hz, and the header states {:.6g} Hz{}",
                  anomalies_.printed_time_differs, rows_, rate_hz, header_.export_rate_hz,
                  time_unit_text(header_.export_rate_hz / rate_hz, header_.export_rate_hz)));
}

// A spreadsheet or script of another locale writes 0,02 for 0.02: then a row has nearly twice the cells.
void RowReader::check_decimal_comma(std::string_view line) const {
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

void RowReader::read(MocapTime until) {
  std::string_view line;
  while (take_.time.empty() || take_.time.back() < until) {
    if (!next_row(line)) break;
    const bool is_short = count_fields(line) < layout_.used_columns;
    // A whole row that the header promised needs no line end.
    if (!lines_.terminated() && (is_short || !layout_.tab_separated)) {
      anomalies_.truncated_last_row = true;
      rows_ -= is_short;
      if (is_short) break;
      // Its last number may lack digits.
      line = line.substr(0, line.rfind(',') + 1);
    }
    read_row(line);
  }
  if (!take_.time.empty() && take_.time.back() >= until) return;
  far_.end();
  check_order();
  check_times();
  check_promise();
}

void RowReader::read_row(std::string_view line) {
  const std::int64_t index = read_index(line);
  std::ranges::fill(numbers_, kNaN);
  not_finite_cells_ = 0;
  const char* const end = line.data() + line.size();
  std::size_t fields = 1;
  const char* const p = read_cells(end_of_cell(line.data(), end), end, fields);
  fields += static_cast<std::size_t>(std::count(p, end, ','));
  if (fields > layout_.written_columns) {
    check_decimal_comma(line);
    ++anomalies_.rows_with_extra_fields;
  }
  if (!add_time(index, layout_.time_unit_s * numbers_.back())) return;
  anomalies_.not_finite_cells += not_finite_cells_;
  for (std::size_t i = 0; i < assets_.size(); ++i) take_.position_m[assets_[i]].push_back(position(i));
}

std::int64_t RowReader::read_index(std::string_view line) const {
  const auto cell = line.substr(
      0, static_cast<std::size_t>(end_of_cell(line.data(), line.data() + line.size()) - line.data()));
  std::int64_t index = 0;
  if (!parse_integer(cell, index)) refuse_cell(0, cell, "is not a frame number");
  if (std::abs(index) > kHighestFrame) refuse_cell(0, cell, "is too large for a frame number");
  return index;
}

// Stands at the comma before each cell; ends behind the last wanted one.
const char* RowReader::read_cells(const char* p, const char* end, std::size_t& fields) {
  for (std::size_t column = 1; column < target_.size() && p != end; ++column) {
    ++p;
    ++fields;
    p = target_[column] == kNoColumn ? end_of_cell(p, end) : read_number(p, end, column);
  }
  return p;
}

const char* RowReader::read_number(const char* p, const char* end, std::size_t column) {
  if (p == end || *p == ',') return p;
  double& number = numbers_[target_[column]];
  if (const char* const behind = parse_plain_decimal(p, end, number)) return behind;
  const char* const behind = end_of_cell(p, end);
  const std::string_view cell(p, static_cast<std::size_t>(behind - p));
  number = kNaN;
  switch (parse_cell(cell, number)) {
    case CellKind::number:
      break;
    case CellKind::empty:
      break;
    case CellKind::not_finite:
      number = kNaN;
      ++not_finite_cells_;
      break;
    case CellKind::unreadable:
      refuse_cell(column, cell, "is not a number");
  }
  return behind;
}

// Whether the row is taken: its time advances.
bool RowReader::add_time(std::int64_t index, double printed_s) {
  if (std::abs(printed_s) > kLatest_s)
    refuse_cell(layout_.time_column, std::to_string(printed_s), "is not a time within a take");
  if (rate_uhz_ == 0 && std::isnan(printed_s))
    throw InputError(lines_.place(),
                     "the row has no time, and the header states no frame rate to make it from");
  const bool is_first = take_.frame.empty();
  if (!is_first && index > previous_index_ + 1 && first_missing_ == 0) first_missing_ = previous_index_ + 1;
  steps_back_ += !is_first && index < previous_index_ ? 1 : 0;
  previous_index_ = index;
  if (!is_first && (index <= take_.frame.back() || (rate_uhz_ == 0 && printed_s <= last_printed_s_))) {
    ++anomalies_.repeated_frames;
    return false;
  }
  if (is_first) {
    first_printed_s_ = printed_s;
    take_.header.first_frame = index;
    if (std::isfinite(printed_s)) take_.first_s = printed_s;
  }
  repeated_times_ += !is_first && printed_s == last_printed_s_ ? 1 : 0;
  if (printed_s > last_printed_s_)
    min_printed_step_s_ = std::min(min_printed_step_s_, printed_s - last_printed_s_);
  last_printed_s_ = printed_s;
  const double since_s = printed_s - first_printed_s_;
  const Duration printed = duration_from_s(std::isnan(since_s) ? 0.0 : since_s);
  const Duration since =
      rate_uhz_ == 0 ? printed : duration_of_frames(index - header_.first_frame, rate_uhz_);
  take_.frame.push_back(index);
  take_.time.push_back(MocapTime{} + since);
  if (rate_uhz_ != 0 && !std::isnan(since_s) &&
      std::abs((printed - since).ns) > duration_of_frames(1, rate_uhz_).ns)
    ++anomalies_.printed_time_differs;
  if (std::isnan(printed_s)) return true;
  if (std::isnan(zero_printed_s_)) {
    zero_printed_s_ = printed_s - since.seconds();
    anomalies_.largest_time_error_s = 0.0;
  }
  anomalies_.largest_time_error_s =
      std::max(anomalies_.largest_time_error_s, std::abs(printed_s - zero_printed_s_ - since.seconds()));
  return true;
}

Eigen::Vector3d RowReader::position(std::size_t number) {
  const double* const written = &numbers_[kSlotsPerAsset * number];
  const Eigen::Vector3d position_m = metres_ * Eigen::Vector3d(written[0], written[1], written[2]);
  bool is_filled = false;
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(position_m[axis]) > kMaxDistance_m) {
      is_filled = true;
      far_.add(written[axis], [&] {
        return cell_refusal(layout_.columns[assets_[number]][static_cast<std::size_t>(axis)],
                            std::to_string(written[axis]) + " " + std::string(name_of(header_.length_unit)),
                            kTooFar);
      });
    }
  if (is_filled) return Eigen::Vector3d::Constant(kFilled);
  if (!position_m.hasNaN()) return position_m;
  if (!position_m.array().isNaN().all()) ++anomalies_.partial_poses;
  return Eigen::Vector3d::Constant(kNaN);
}

void RowReader::refuse_cell(std::size_t column, std::string_view cell, const char* problem) const {
  throw cell_refusal(column, cell, problem);
}

InputError RowReader::cell_refusal(std::size_t column, std::string_view cell, const char* problem) const {
  std::string who = column == 0 ? "frame" : column == layout_.time_column ? "time" : "";
  for (std::size_t i = 0; who.empty() && i < layout_.columns.size(); ++i)
    for (std::size_t slot = 0; slot < kSlotsPerAsset; ++slot)
      if (layout_.columns[i][slot] == column) who = key_of(header_, i) + ", " + std::string(kSlotNames[slot]);
  return {lines_.place(), "column " + std::to_string(column + 1) + " (" + who + "): \"" +
                              std::string(cell.substr(0, 40)) + "\" " + problem};
}

}  // namespace

void read_rows(LineReader& lines, const ColumnLayout& layout, const std::vector<std::size_t>& assets,
               MocapTime until, MocapTake& take) {
  RowReader(lines, layout, assets, take).read(until);
}

}  // namespace trilat
