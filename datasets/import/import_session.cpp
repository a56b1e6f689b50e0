// SPDX-License-Identifier: MIT
#include "datasets/import/import_session.h"

#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {
namespace {

constexpr std::int64_t kFramesPerFlush = 256;

}  // namespace

ImportSession::ImportSession(const std::filesystem::path& output, const SessionHeader& header,
                             ChunkCompression compression)
    : output_(output), compression_(compression) {
  writer_ = std::make_unique<SessionWriter>(output, header, compression);
  report_.note = header.note;
  for (const SensorDescription& sensor : header.sensors) {
    report_.sensors.push_back({.name = sensor.name, .file = {}});
    const FrameNumbers numbers(sensor.nominal_rate_hz, sensor.tick_ns);
    streams_.push_back({numbers, numbers});
  }
}

ImportSession::~ImportSession() {
  if (!writer_) return;
  writer_.reset();
  std::error_code ignored;
  std::filesystem::remove(partial_name(output_), ignored);
}

void ImportSession::flush_now_and_then() {
  if (++unflushed_frames_ < kFramesPerFlush) return;
  writer_->flush();
  unflushed_frames_ = 0;
}

void ImportSession::add_bodies(std::size_t sensor, const FileFrame& frame, const std::string& place) {
  ImportedSensor& report = report_.sensors.at(sensor);
  const auto stamp = streams_[sensor].bodies.stamp(frame.ticks, frame.sequence, place, report.left_out);
  if (!stamp) return;
  writer_->add_body_frame(sensor, {*stamp, frame.floor_plane, frame.bodies});
  ++report.body_frames;
  report.bodies += static_cast<std::int64_t>(frame.bodies.size());
  flush_now_and_then();
}

void ImportSession::add_depth(std::size_t sensor, std::int64_t ticks, std::optional<std::int64_t> sequence,
                              std::span<const std::uint16_t> depth_mm, const std::string& place) {
  ImportedSensor& report = report_.sensors.at(sensor);
  const auto stamp = streams_[sensor].depth.stamp(ticks, sequence, place, report.left_out);
  if (!stamp) return;
  writer_->add_depth_frame(sensor, encode_depth_frame(*stamp, depth_mm, compression_));
  ++report.depth_frames;
  flush_now_and_then();
}

ImportReport ImportSession::finish() {
  for (std::size_t s = 0; s < streams_.size(); ++s) {
    ImportedSensor& report = report_.sensors[s];
    report.gap_frames = streams_[s].bodies.gap_frames() + streams_[s].depth.gap_frames();
    if (report.body_frames + report.depth_frames == 0)
      throw InputError(report.file,
                       "holds no frame that can be imported" +
                           (report.left_out.first.empty() ? "" : "; first: " + report.left_out.first));
  }
  writer_->finish();
  writer_.reset();
  return report_;
}

}  // namespace trilat
