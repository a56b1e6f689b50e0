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
constexpr double kHighestWord = 65535.0;

std::vector<std::byte> first_block(const ByteFile& file) {
  std::vector<std::byte> block(kC3dBlock);
  if (!file.read(0, block)) throw InputError(file.path(), "the file ends within the header of a C3D file");
  return block;
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
  header_.format = "C3D";
  header_.take_name = path.stem().string();
  points_ = count("POINT:USED", 2);
  const auto analog = static_cast<std::size_t>(word(3));
  if (points_ == 0) refuse(analog > 0 ? "holds analog channels only, and no points" : "holds no points");
  read_unit_and_rate();
  data_start_ = kC3dBlock * (std::max<std::uint64_t>(count("POINT:DATA_START", 9), 1) - 1);
  bytes_.resize(number_bytes_ * (4 * points_ + analog));
  read_frame_range();
  check_size();
  name_points();
}

void C3dRows::refuse(const std::string& problem) const { throw InputError(file_.path(), problem); }

// Words of the first block count from 1, as the format's guide does.
double C3dRows::word(std::size_t number) const {
  return static_cast<std::uint16_t>(c3d_integer(start_, 2 * (number - 1), parameters_.processor()));
}

// A parameter, or the header's word where it is not there; some programs write a count as a real number.
std::uint64_t C3dRows::count(const char* name, std::size_t header_word) const {
  const double value = parameters_.number(name).value_or(word(header_word));
  if (!(value >= 0.0 && value <= kHighestWord)) refuse(std::string(name) + " is " + std::to_string(value));
  return static_cast<std::uint64_t>(value);
}

void C3dRows::read_unit_and_rate() {
  const auto units = parameters_.texts("POINT:UNITS");
  const auto unit = length_unit_from_text(units.empty() ? "" : units[0]);
  if (!unit)
    refuse("POINT:UNITS is " + (units.empty() ? "not stated" : "\"" + units[0] + "\"") +
           "; it must be a unit of length such as mm");
  const auto real = [&](const char* name, std::size_t offset) {
    return parameters_.number(name).value_or(c3d_real(start_, offset, parameters_.processor()));
  };
  const double rate_hz = real("POINT:RATE", 20), scale = real("POINT:SCALE", 12);
  if (!is_frame_rate(rate_hz))
    refuse("POINT:RATE is " + std::to_string(rate_hz) + "; it must be 1 to 9000 Hz");
  if (!std::isfinite(scale) || scale == 0.0)
    refuse("POINT:SCALE is " + std::to_string(scale) + "; it must be a number other than zero");
  header_.length_unit = *unit;
  header_.export_rate_hz = rate_hz;
  number_bytes_ = scale < 0.0 ? 4 : 2;
  scale_m_ = metres_per(*unit) * (scale < 0.0 ? 1.0 : scale);
}

// The header's words end at 65535; longer recordings have their frames in TRIAL, each as two words.
void C3dRows::read_frame_range() {
  double first = word(4), last = word(5);
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
  } else if (last == kHighestWord) {
    const auto frames = [&](const char* name) { return parameters_.number(name).value_or(0.0); };
    last = std::max({last, first - 1.0 + frames("POINT:FRAMES"), first - 1.0 + frames("POINT:LONG_FRAMES")});
  }
  if (!(first >= 0.0 && last >= first - 1.0 && last <= static_cast<double>(kHighestFrame)))
    refuse("the frames go from " + std::to_string(first) + " to " + std::to_string(last));
  header_.first_frame = static_cast<std::int64_t>(first);
  frames_ = static_cast<std::int64_t>(last - first) + 1;
  header_.total_exported_frames = frames_;
}

void C3dRows::check_size() const {
  const std::uint64_t room = (file_.size() - std::min(file_.size(), data_start_)) / bytes_.size();
  if (static_cast<std::uint64_t>(frames_) > room)
    refuse("the header promises " + std::to_string(frames_) + " frames of " + std::to_string(points_) +
           " points, but the file has room for " + std::to_string(room));
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
    refuse("the file became shorter while it was read");
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
    refuse("frame " + std::to_string(header_.first_frame + frame_) + ", " + key_of(header_, point) + " " +
           kTooFar);
  pose.position_m = position_m;
  return pose;
}

}  // namespace trilat
