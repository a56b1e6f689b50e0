// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_writer.h"

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>

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

// Calls `write(number, frame)` with every frame, of which the first is number 1.
template <class Write>
void for_each_frame(const JointTrack& track, const Write& write) {
  JointFrame frame;
  double first_s = 0.0;
  for (std::int64_t i = 0; i < track.frames; ++i) {
    track.next(frame);
    if (i == 0) first_s = frame.time_s;
    const double periods = (frame.time_s - first_s) * track.rate_hz;
    TRILAT_CHECK(std::abs(periods - static_cast<double>(i)) <= 0.5, "frames follow each other at the rate");
    TRILAT_CHECK(frame.position_m.size() == track.joints.size(), "a frame has a position for each joint");
    TRILAT_CHECK(frame.sigma_m.empty() || frame.sigma_m.size() == track.joints.size(),
                 "a frame has an uncertainty for each joint or none");
    TRILAT_CHECK(frame.status.empty() || frame.status.size() == track.joints.size(),
                 "a frame has a status for each joint or none");
    write(i + 1, frame);
  }
}

double sigma_of(const JointFrame& frame, std::size_t joint) {
  return frame.sigma_m.empty() ? std::nan("") : frame.sigma_m[joint];
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

void OptitrackCsvWriter::write(std::int64_t frame, std::span<const Eigen::Vector3d> position_m) {
  TRILAT_CHECK(position_m.size() == header_.assets.size(), "a frame has a position for each asset");
  row_ = std::to_string(frame);
  append_number(row_, static_cast<double>(frame) / header_.export_rate_hz);
  for (const Eigen::Vector3d& position : position_m)
    for (const double component : position) append_number(row_, component * per_metre_);
  file_.add_bytes(row_ += '\n');
  ++frames_;
}

void OptitrackCsvWriter::finish() {
  TRILAT_CHECK(frames_ == header_.total_exported_frames.value_or(frames_),
               "as many frames were written as the header states");
  file_.publish();
}

std::string trc_header(const std::filesystem::path& path, const std::vector<std::string>& joints,
                       double rate_hz, std::int64_t frames, LengthUnit unit) {
  std::string text = fmt::format(
      "PathFileType\t4\t(X/Y/Z)\t{}\n"
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
      "{:g}\t{:g}\t{}\t{}\t{}\t{:g}\t1\t{}\nFrame#\tTime",
      path.filename().string(), rate_hz, rate_hz, frames, joints.size(),
      unit == LengthUnit::millimetre ? "mm" : "m", rate_hz, frames);
  for (const std::string& joint : joints) text += fmt::format("\t{}\t\t", joint);
  text += "\n\t";
  for (std::size_t j = 1; j <= joints.size(); ++j) text += fmt::format("\tX{}\tY{}\tZ{}", j, j, j);
  return text + "\n\n";
}

void write_trc(const std::filesystem::path& path, const JointTrack& track) {
  TextOutput text(path);
  text.add_bytes(trc_header(path, track.joints, track.rate_hz, track.frames, LengthUnit::millimetre));
  for_each_frame(track, [&](std::int64_t number, const JointFrame& frame) {
    text.add("{}\t{:.6f}", number, frame.time_s);
    for (const Eigen::Vector3d& position_m : frame.position_m)
      if (position_m.allFinite())
        text.add("\t{:.3f}\t{:.3f}\t{:.3f}", 1e3 * position_m.x(), 1e3 * position_m.y(),
                 1e3 * position_m.z());
      else
        text.add("\t\t\t");
    text.add("\n");
  });
  text.publish();
}

void write_joint_csv(const std::filesystem::path& path, const JointTrack& track) {
  TextOutput text(path);
  text.add("{}", kJointCsvHead);
  for_each_frame(track, [&](std::int64_t number, const JointFrame& frame) {
    for (std::size_t j = 0; j < track.joints.size(); ++j) {
      text.add("{},{:.6f},{},{}", number, frame.time_s, csv_field(track.joints[j]),
               frame.status.empty() ? std::string() : csv_field(frame.status[j]));
      for (const double number_m :
           {frame.position_m[j].x(), frame.position_m[j].y(), frame.position_m[j].z(), sigma_of(frame, j)})
        if (std::isfinite(number_m) && frame.position_m[j].allFinite())
          text.add(",{:.6f}", number_m);
        else
          text.add(",");
      text.add("\n");
    }
  });
  text.publish();
}

}  // namespace trilat
