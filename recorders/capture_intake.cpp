// SPDX-License-Identifier: MIT
#include "recorders/capture_intake.h"

#include <algorithm>
#include <new>
#include <string>

#include "datasets/base/error.h"
#include "datasets/session/session_limits.h"
#include "datasets/session/session_reader.h"

namespace trilat {
namespace {

// Makes the event's depth what the file takes.
void make_ready(SourceEvent& event, ChunkCompression compression) {
  if (const auto* raw = std::get_if<DepthFrame>(&event.data)) {
    event.data = encode_depth_frame(raw->stamp, raw->depth_mm, compression);
    return;
  }
  auto* encoded = std::get_if<EncodedDepthFrame>(&event.data);
  if (!encoded || encoded->compression == compression) return;
  try {
    std::vector<std::uint16_t> depth_mm(kDepthPixels);
    decode_depth_frame({"a depth frame", encoded->compression, std::move(encoded->chunk)}, depth_mm);
    event.data = encode_depth_frame(encoded->stamp, depth_mm, compression);
  } catch (const InputError& error) {
    event.data = SourceNotice{std::string(error.what()) + "; it was left out"};
  }
}

bool is_torn(const SourceEvent& event) {
  const auto* depth = std::get_if<DepthFrame>(&event.data);
  return depth && depth->depth_mm.size() != kDepthPixels;
}

// False for what would make the whole session unreadable: a time that no clock shows.
bool is_believable(const SourceEvent& event, const SensorDescription& sensor) {
  if (const auto* exchange = std::get_if<ClockExchange>(&event.data)) return is_plausible(*exchange);
  if (const auto* frame = std::get_if<BodyFrame>(&event.data))
    return is_plausible(frame->stamp, sensor.tick_ns);
  if (const auto* frame = std::get_if<DepthFrame>(&event.data))
    return is_plausible(frame->stamp, sensor.tick_ns);
  if (const auto* frame = std::get_if<EncodedDepthFrame>(&event.data))
    return is_plausible(frame->stamp, sensor.tick_ns);
  return true;
}

}  // namespace

CaptureIntake::CaptureIntake(const std::vector<std::unique_ptr<FrameSource>>& sources, CaptureQueue& queue,
                             ChunkCompression compression, int workers)
    : sources_(sources), queue_(queue), running_(sources.size()) {
  try {
    std::size_t first_sensor = 0;
    for (const auto& source : sources) {
      threads_.emplace_back([this, first_sensor, &source] { carry(*source, first_sensor); });
      first_sensor += source->header().sensors.size();
    }
    for (int w = 0; w < std::max(1, workers); ++w)
      threads_.emplace_back([this, compression] { compress(compression); });
  } catch (...) {  // a thread that cannot be started
    end();
    throw;
  }
}

CaptureIntake::~CaptureIntake() { end(); }

void CaptureIntake::end() {
  stop();
  queue_.close();
  for (std::thread& thread : threads_) thread.join();
}

void CaptureIntake::stop() {
  for (const auto& source : sources_) source->stop();
}

void CaptureIntake::carry(FrameSource& source, std::size_t first_sensor) {
  try {
    while (auto event = source.next()) {
      const bool believable = is_believable(*event, source.header().sensors.at(event->sensor));
      event->sensor += first_sensor;
      if (is_torn(*event) || !believable) {
        queue_.drop(event->sensor);
        continue;
      }
      queue_.push(std::move(*event), !source.live());
    }
  } catch (const std::exception& error) {
    failed_ = true;
    queue_.push({first_sensor, SourceNotice{std::string("the source broke: ") + error.what()}}, false);
  }
  if (--running_ == 0) queue_.close();
}

void CaptureIntake::compress(ChunkCompression compression) {
  while (CaptureQueue::Entry* entry = queue_.take_work()) {
    try {
      make_ready(entry->event, compression);
    } catch (const std::bad_alloc&) {
      queue_.drop(entry->event.sensor);
      entry->event.data = SourceNotice{"there was no memory for a depth frame"};
    }
    queue_.finish(entry);
  }
}

}  // namespace trilat
