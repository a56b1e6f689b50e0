// SPDX-License-Identifier: MIT
#include "datasets/mocap/optitrack_csv_writer.h"

#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/core.h>

#include "datasets/base/error.h"

namespace trilat {
namespace {

std::string_view motive_unit(LengthUnit unit) {
  static constexpr std::array<std::string_view, 5> kNames{"Meters", "Centimeters", "Millimeters", "Inches",
                                                          "Feet"};
  return kNames[static_cast<std::size_t>(unit)];
}

// A row of an export is one line, whatever stands between quotes.
std::string on_one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

std::string cell(const std::string& text) { return on_one_line(csv_field(text)); }

// A comma and six decimals, or the comma alone.
void append_number(std::string& text, double value) {
  text += ',';
  if (!std::isfinite(value)) return;
  constexpr std::int64_t kMillion = 1'000'000;
  const std::int64_t millionths = std::llround(value * 1e6);
  const std::int64_t magnitude = std::abs(millionths);
  std::array<char, 24> digits;
  const char* const end =
      std::to_chars(digits.data(), digits.data() + digits.size(), magnitude / kMillion).ptr;
  if (millionths < 0) text += '-';
  text.append(digits.data(), static_cast<std::size_t>(end - digits.data()));
  text += '.';
  for (std::int64_t rest = magnitude % kMillion, unit = kMillion / 10; unit > 0; unit /= 10)
    text += static_cast<char>('0' + rest / unit % 10);
}

}  // namespace

OptitrackCsvWriter::OptitrackCsvWriter(const std::filesystem::path& path, MocapHeader header)
    : file_(path), header_(std::move(header)), per_metre_(1.0 / metres_per(header_.length_unit)) {
  TRILAT_CHECK(header_.export_rate_hz > 0.0, "the export rate is stated");
  write_header();
}

void OptitrackCsvWriter::write_header() {
  const double capture_hz =
      std::isnan(header_.capture_rate_hz) ? header_.export_rate_hz : header_.capture_rate_hz;
  std::string text = fmt::format(
      "Format Version,1.25,Take Name,{},Take Notes,{},Capture Frame Rate,{:.6f},Export Frame "
      "Rate,{:.6f},Capture Start Time,{}",
      cell(header_.take_name), cell(header_.take_notes), capture_hz, header_.export_rate_hz,
      cell(header_.capture_start_text));
  const auto count = [&](const char* key, std::optional<std::int64_t> value) {
    if (value) text += fmt::format(",{},{}", key, *value);
  };
  count("Capture Start Frame", header_.capture_start_frame);
  count("Total Frames in Take", header_.total_frames_in_take);
  count("Total Exported Frames", header_.total_exported_frames);
  text += fmt::format(",Rotation Type,Quaternion,Length Units,{},Coordinate Space,{}\n\n",
                      motive_unit(header_.length_unit), cell(header_.coordinate_space));

  const auto row = [&](const char* label, const auto& text_of) {
    text += label;
    for (const MocapAsset& asset : header_.assets)
      for (std::size_t axis = 0; axis < 3; ++axis) (text += ',') += text_of(asset);
    text += '\n';
  };
  row(",Type", [](const MocapAsset& asset) { return motive_name_of(asset.type); });
  row(",Name", [](const MocapAsset& asset) { return cell(asset.name); });
  row(",ID", [](const MocapAsset& asset) { return on_one_line(csv_quoted(asset.id)); });
  row(",Parent", [](const MocapAsset& asset) { return cell(asset.parent); });
  std::string kinds = ",";
  std::string axes = "Frame,Time (Seconds)";
  for (std::size_t i = 0; i < header_.assets.size(); ++i) {
    kinds += ",Position,Position,Position";
    axes += ",X,Y,Z";
  }
  file_.add_bytes(text + kinds + "\n" + axes + "\n");
}

void OptitrackCsvWriter::write(const MocapFrame& frame) {
  TRILAT_CHECK(frame.poses.size() == header_.assets.size(), "a frame has a pose for each asset");
  row_ = std::to_string(frame.index);
  append_number(row_, static_cast<double>(frame.index) / header_.export_rate_hz);
  for (const MocapPose& pose : frame.poses)
    for (const double component : pose.position_m) append_number(row_, component * per_metre_);
  file_.add_bytes(row_ += '\n');
  ++frames_;
}

void OptitrackCsvWriter::finish() {
  TRILAT_CHECK(frames_ == header_.total_exported_frames.value_or(frames_),
               "as many frames were written as the header states");
  file_.publish();
}

}  // namespace trilat
