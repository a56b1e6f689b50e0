// SPDX-License-Identifier: MIT
#include "datasets/mocap/c3d_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numeric>
#include <string>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr int kMagic = 0x50;
constexpr double kHighestFrameField = 65535.0;  // a word of 16 bits

std::vector<std::byte> first_block(const ByteFile& file) {
  std::vector<std::byte> block(kC3dBlock);
  if (!file.read(0, block)) throw InputError(file.path(), "the file ends within the header of a C3D file");
  return block;
}

// Words count from 1, as the format's guide does.
double header_word(std::span<const std::byte> block, std::size_t word, C3dProcessor processor) {
  return static_cast<std::uint16_t>(c3d_integer(block, 2 * (word - 1), processor));
}

}  // namespace

bool is_c3d(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  std::ifstream file(path, std::ios::binary);
  const int parameters = file.get(), magic = file.get();
  return magic == kMagic && parameters > 0 && parameters < ' ';
}

C3dRows::C3dRows(const std::filesystem::path& path, MocapHeader& header)
    : file_(path),
      header_(header),
      start_(first_block(file_)),
      parameters_(file_, std::to_integer<std::size_t>(start_[0])) {
  const C3dProcessor processor = parameters_.processor();
  const auto word = [&](std::size_t number) { return header_word(start_, number, processor); };
  points_ = static_cast<std::size_t>(parameters_.number("POINT:USED").value_or(word(2)));
  const double analog = word(3);
  if (points_ == 0)
    throw InputError(file_.path(),
                     analog > 0.0 ? "holds analog channels only, and no points" : "holds no points");
  const auto units = parameters_.texts("POINT:UNITS");
  const auto unit = length_unit_from_text(units.empty() ? "" : units[0]);
  if (!unit)
    throw InputError(file_.path(), "POINT:UNITS is " +
                                       (units.empty() ? "not stated" : "\"" + units[0] + "\"") +
                                       "; it must be a unit of length such as mm");
  const double rate_hz = parameters_.number("POINT:RATE").value_or(c3d_real(start_, 20, processor));
  if (!is_frame_rate(rate_hz))
    throw InputError(file_.path(), "POINT:RATE is " + std::to_string(rate_hz) + "; it must be 1 to 9000 Hz");
  header_.format = "C3D";
  header_.take_name = path.stem().string();
  header_.length_unit = *unit;
  header_.export_rate_hz = header_.capture_rate_hz = rate_hz;
  const double scale = parameters_.number("POINT:SCALE").value_or(c3d_real(start_, 12, processor));
  number_bytes_ = scale < 0.0 ? 4 : 2;
  scale_m_ = metres_per(*unit) * (scale < 0.0 ? 1.0 : scale);
  data_start_ =
      kC3dBlock * static_cast<std::uint64_t>(
                      std::max(1.0, parameters_.number("POINT:DATA_START").value_or(word(9))) - 1.0);
  bytes_.resize(number_bytes_ * (4 * points_ + static_cast<std::size_t>(analog)));
  read_frame_range();
  check_size();
  name_points();
}

// The header's words end at 65535; longer recordings have their frames in TRIAL, each as two words.
void C3dRows::read_frame_range() {
  double first = header_word(start_, 4, parameters_.processor());
  double last = header_word(start_, 5, parameters_.processor());
  const auto long_field = [&](const char* name) -> std::optional<double> {
    const auto low = parameters_.number(name, 0);
    if (!low) return {};
    return *low + 65536.0 * parameters_.number(name, 1).value_or(0.0);
  };
  const auto long_first = long_field("TRIAL:ACTUAL_START_FIELD"),
             long_last = long_field("TRIAL:ACTUAL_END_FIELD");
  if (long_first && long_last) {
    first = *long_first;
    last = *long_last;
  } else if (last == kHighestFrameField) {
    last = std::max({last, first - 1.0 + parameters_.number("POINT:FRAMES").value_or(0.0),
                     first - 1.0 + parameters_.number("POINT:LONG_FRAMES").value_or(0.0)});
  }
  if (!(first >= 0.0 && last >= first - 1.0 && last <= static_cast<double>(kHighestFrame)))
    throw InputError(file_.path(),
                     "the frames go from " + std::to_string(first) + " to " + std::to_string(last));
  header_.first_frame = static_cast<std::int64_t>(first);
  frames_ = static_cast<std::int64_t>(last - first) + 1;
  header_.total_exported_frames = frames_;
}

void C3dRows::check_size() const {
  const std::uint64_t room = (file_.size() - std::min(file_.size(), data_start_)) / bytes_.size();
  if (static_cast<std::uint64_t>(frames_) > room)
    throw InputError(file_.path(), "the header promises " + std::to_string(frames_) + " frames of " +
                                       std::to_string(points_) + " points, but the file has room for " +
                                       std::to_string(room));
}

// Labels beyond the 255th stand in LABELS2, and so on.
void C3dRows::name_points() {
  std::vector<std::string> labels = parameters_.texts("POINT:LABELS");
  for (int part = 2; labels.size() < points_; ++part) {
    const auto more = parameters_.texts("POINT:LABELS" + std::to_string(part));
    if (more.empty()) break;
    labels.insert(labels.end(), more.begin(), more.end());
  }
  labels.resize(points_);
  for (std::size_t i = 0; i < points_; ++i) {
    const std::string number = std::to_string(i + 1);
    header_.assets.push_back({.type = AssetType::marker,
                              .name = labels[i].empty() ? "marker " + number : labels[i],
                              .id = number,
                              .parent = {},
                              .has_rotation = false,
                              .has_position = true});
  }
  assets_.resize(points_);
  std::iota(assets_.begin(), assets_.end(), std::size_t{0});
}

bool C3dRows::next(MocapFrame& frame, MocapAnomalies& anomalies) {
  if (frame_ == frames_) return false;
  if (!file_.read(data_start_ + static_cast<std::uint64_t>(frame_) * bytes_.size(), bytes_))
    throw InputError(file_.path(), "the file became shorter while it was read");
  frame.index = header_.first_frame + frame_;
  frame.time = MocapTime{} + duration_of_frames(frame_, std::llround(header_.export_rate_hz * 1e6));
  frame.printed_time_s = kMissing;
  frame.poses.assign(points_, MocapPose());
  for (const std::size_t point : assets_) frame.poses[point] = read_point(point, anomalies);
  ++frame_;
  return true;
}

MocapPose C3dRows::read_point(std::size_t point, MocapAnomalies& anomalies) const {
  std::array<double, 4> numbers;  // x, y, z, residual
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t offset = number_bytes_ * (4 * point + i);
    numbers[i] = number_bytes_ == 4
                     ? static_cast<double>(c3d_real(bytes_, offset, parameters_.processor()))
                     : static_cast<double>(c3d_integer(bytes_, offset, parameters_.processor()));
  }
  MocapPose pose;
  if (numbers[3] < 0.0) return pose;
  const Eigen::Vector3d position_m = scale_m_ * Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
  if (!position_m.allFinite()) {
    ++anomalies.not_finite_cells;
    return pose;
  }
  if ((position_m.array().abs() > kFarthest_m).any())
    throw InputError(file_.path(), "frame " + std::to_string(header_.first_frame + frame_) + ", " +
                                       key_of(header_, point) + " " + kTooFar);
  pose.position_m = position_m;
  return pose;
}

}  // namespace trilat
