// SPDX-License-Identifier: MIT
#include "datasets/import/import_session.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {

namespace {

constexpr std::int64_t kFramesPerFlush = 256;

// 18 years of 100 ns each: later times are no clock's, and readers of sessions refuse them.
constexpr std::int64_t kLargestTicks = (std::int64_t{1} << 59) / 100;
constexpr std::int64_t kLongestGapFrames = std::int64_t{1} << 40;

void remember(LeftOut& left_out, const std::string& place, const std::string& problem) {
  if (left_out.first.empty()) left_out.first = place + " " + problem;
}

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

void count_torn(LeftOut& left_out, const std::string& place, const TornRow& row) {
  ++left_out.torn_rows;
  remember(left_out, place, row.problem);
}

std::optional<FrameStamp> FrameNumbers::stamp(std::int64_t ticks, std::optional<std::int64_t> sequence,
                                              const std::string& place, LeftOut& left_out) {
  if (ticks < -kLargestTicks || ticks > kLargestTicks) {
    count_torn(left_out, place, {fmt::format("has the time {}, which is beyond all clocks", ticks)});
    return {};
  }
  if (last_ && ticks <= last_->device_ticks) {
    const bool repeated = ticks == last_->device_ticks;
    ++(repeated ? left_out.repeated_times : left_out.backward_times);
    remember(left_out, place,
             repeated ? "has the time of the frame before" : "has a time before that of the frame before");
    return {};
  }
  FrameStamp stamp{sequence.value_or(0), ticks, ticks * tick_ns_};
  if (last_) {
    const double elapsed_s =
        1e-9 * static_cast<double>(tick_ns_) * static_cast<double>(ticks - last_->device_ticks);
    const double periods = std::min(std::round(elapsed_s * rate_hz_), static_cast<double>(kLongestGapFrames));
    const std::int64_t step = std::max<std::int64_t>(1, static_cast<std::int64_t>(periods));
    if (!sequence || *sequence <= last_->sequence) stamp.sequence = last_->sequence + step;
    gap_frames_ += stamp.sequence - last_->sequence - 1;
  }
  last_ = stamp;
  return stamp;
}

}  // namespace trilat
