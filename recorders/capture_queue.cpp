// SPDX-License-Identifier: MIT
#include "recorders/capture_queue.h"

#include <algorithm>
#include <new>
#include <string>

#include "datasets/base/error.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_types.h"

namespace trilat {
namespace {

constexpr std::size_t kRoomForSmall_bytes = std::size_t{64} << 20;

std::size_t bytes_of(const SourceEvent& event) {
  if (const auto* bodies = std::get_if<BodyFrame>(&event.data))
    return sizeof(CaptureQueue::Entry) + bodies->bodies.size() * sizeof(Body);
  if (const auto* depth = std::get_if<DepthFrame>(&event.data)) return depth->depth_mm.size() * 2;
  if (const auto* depth = std::get_if<EncodedDepthFrame>(&event.data)) return depth->chunk.size();
  return sizeof(CaptureQueue::Entry);
}

bool is_depth(const SourceEvent& event) {
  return std::holds_alternative<DepthFrame>(event.data) ||
         std::holds_alternative<EncodedDepthFrame>(event.data);
}

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

CaptureQueue::CaptureQueue(std::size_t sensors, std::size_t limit_bytes)
    : limit_bytes_(limit_bytes), dropped_(sensors, 0) {}

void CaptureQueue::push(SourceEvent event, bool may_wait) {
  const std::size_t bytes = bytes_of(event);
  const bool depth = is_depth(event);
  std::unique_lock lock(mutex_);
  // an empty queue takes a frame of any size
  const auto has_room = [&] { return closed_ || bytes_ == 0 || bytes_ + bytes <= limit_bytes_; };
  if (may_wait) room_.wait(lock, has_room);
  if (closed_) return;
  // what is small has room of its own, so that depth is what a slow disk costs
  if (depth ? !has_room() : bytes_ + bytes > limit_bytes_ + kRoomForSmall_bytes) {
    ++dropped_[event.sensor];
    return;
  }
  bytes_ += bytes;
  entries_.push_back(std::make_unique<Entry>(Entry{std::move(event), bytes, !depth}));
  (depth ? work_ : ready_).notify_one();
}

void CaptureQueue::drop(std::size_t sensor) {
  const std::lock_guard lock(mutex_);
  ++dropped_.at(sensor);
}

void CaptureQueue::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  room_.notify_all();
  work_.notify_all();
  ready_.notify_all();
}

CaptureQueue::Entry* CaptureQueue::take_work() {
  std::unique_lock lock(mutex_);
  while (true) {
    while (next_work_ < entries_.size()) {
      Entry* entry = entries_[next_work_++].get();
      if (!entry->ready) return entry;
    }
    if (closed_) return nullptr;
    work_.wait(lock);
  }
}

void CaptureQueue::finish(Entry* entry) {
  const std::lock_guard lock(mutex_);
  entry->ready = true;
  ready_.notify_one();
}

std::optional<SourceEvent> CaptureQueue::pop(std::chrono::steady_clock::time_point until) {
  std::unique_ptr<Entry> entry;
  {
    std::unique_lock lock(mutex_);
    ready_.wait_until(lock, until, [&] { return front_ready() || (closed_ && entries_.empty()); });
    if (!front_ready()) return std::nullopt;
    entry = std::move(entries_.front());
    entries_.pop_front();
    if (next_work_ > 0) --next_work_;
    bytes_ -= entry->bytes;
    room_.notify_all();
  }
  return std::move(entry->event);
}

bool CaptureQueue::drained() const {
  const std::lock_guard lock(mutex_);
  return closed_ && entries_.empty();
}

std::size_t CaptureQueue::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

std::int64_t CaptureQueue::dropped(std::size_t sensor) const {
  const std::lock_guard lock(mutex_);
  return dropped_.at(sensor);
}

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
