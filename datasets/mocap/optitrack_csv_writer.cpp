// SPDX-License-Identifier: MIT
#include "datasets/mocap/optitrack_csv_writer.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <iterator>

#include <fmt/compile.h>
#include <fmt/format.h>

#include "datasets/base/check.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {

OptitrackCsvWriter::OptitrackCsvWriter(const std::filesystem::path& path, const Take& take)
    : path_(path),
      file_(std::fopen(partial_name(path).c_str(), "wb"), std::fclose),
      rate_hz_(take.rate_hz),
      stated_frames_(take.frames),
      markers_(take.markers.size()) {
  if (!file_) throw InputError(path.string(), std::string("cannot be written: ") + std::strerror(errno));
  write_header(take);
}

void OptitrackCsvWriter::write_header(const Take& take) {
  auto out = std::back_inserter(buffer_);
  fmt::format_to(
      out,
      "Format Version,1.25,Take Name,{},Take Notes,,Capture Frame Rate,{:.6f},Export Frame Rate,{:.6f},"
      "Capture Start Time,{},Capture Start Frame,0,Total Frames in Take,{},Total Exported Frames,{},"
      "Rotation Type,Quaternion,Length Units,Meters,Coordinate Space,Global\r\n\r\n",
      take.name, take.rate_hz, take.rate_hz, take.capture_start, take.frames, take.frames);
  const auto row = [&](const char* label, const auto& cell) {
    fmt::format_to(out, "{}", label);
    for (std::size_t m = 0; m < markers_; ++m)
      for (int axis = 0; axis < 3; ++axis) fmt::format_to(out, ",{}", cell(m, axis));
    buffer_ += "\r\n";
  };
  row(",Type", [](std::size_t, int) { return "Marker"; });
  row(",Name", [&](std::size_t m, int) { return take.markers[m]; });
  row(",ID", [](std::size_t m, int) { return fmt::format("\"{:X}\"", 0xA000 + m); });
  row(",Parent", [](std::size_t, int) { return ""; });
  row(",", [](std::size_t, int) { return "Position"; });
  row("Frame,Time (Seconds)", [](std::size_t, int axis) { return std::string(1, "XYZ"[axis]); });
}

void OptitrackCsvWriter::add(std::span<const Eigen::Vector3d> positions_m) {
  TRILAT_CHECK(positions_m.size() == markers_, "a frame has one position a marker");
  auto out = std::back_inserter(buffer_);
  fmt::format_to(out, FMT_COMPILE("{},{:.6f}"), frames_, static_cast<double>(frames_) / rate_hz_);
  for (const Eigen::Vector3d& p : positions_m) {
    if (p.allFinite())
      fmt::format_to(out, FMT_COMPILE(",{:.6f},{:.6f},{:.6f}"), p.x(), p.y(), p.z());
    else
      buffer_ += ",,,";
  }
  buffer_ += "\r\n";
  ++frames_;
  if (buffer_.size() > (1u << 20)) flush();
}

void OptitrackCsvWriter::flush() {
  if (std::fwrite(buffer_.data(), 1, buffer_.size(), file_.get()) != buffer_.size())
    throw InputError(path_.string(), std::string("cannot be written: ") + std::strerror(errno));
  buffer_.clear();
}

void OptitrackCsvWriter::finish() {
  TRILAT_CHECK(frames_ == stated_frames_, "as many frames as stated were written");
  flush();
  if (std::fflush(file_.get()) != 0)
    throw InputError(path_.string(), std::string("cannot be written: ") + std::strerror(errno));
  file_.reset();
  publish_file(partial_name(path_), path_);
}

}  // namespace trilat
