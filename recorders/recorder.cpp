// SPDX-License-Identifier: MIT
#include "recorders/recorder.h"

#include "datasets/base/error.h"
#include "datasets/session/session_writer.h"

namespace trilat {
namespace {

constexpr std::uint64_t kEventsBetweenLooks = 240;  // about a second of four sensors with depth and bodies

struct Store {
  SessionWriter& writer;
  const RecordOptions& options;
  RecordSummary& summary;
  std::size_t sensor;

  void operator()(const BodyFrame& frame) {
    writer.add_body_frame(sensor, frame);
    ++summary.body_frames;
  }
  void operator()(const DepthFrame& frame) {
    writer.add_depth_frame(sensor,
                           encode_depth_frame(frame.stamp, frame.depth_mm, options.depth_compression));
    ++summary.depth_frames;
  }
  void operator()(const EncodedDepthFrame& frame) {
    writer.add_depth_frame(sensor, frame);
    ++summary.depth_frames;
  }
  void operator()(const SourceNotice&) {}
  void operator()(const ClockExchange& exchange) { writer.add_clock_exchange(sensor, exchange); }
  void operator()(const DropCount& count) { writer.add_drop_count(sensor, count); }
};

}  // namespace

RecordSummary record(FrameSource& source, const std::filesystem::path& path, const RecordOptions& options) {
  SessionWriter writer(path, source.header(), options.depth_compression);
  RecordSummary summary;
  std::uint64_t events = 0;
  while (auto event = source.next()) {
    std::visit(Store{writer, options, summary, event->sensor}, event->data);
    if (++events % kEventsBetweenLooks == 0 && options.stop_requested && options.stop_requested())
      throw Interrupted();
  }
  writer.finish();
  return summary;
}

}  // namespace trilat
