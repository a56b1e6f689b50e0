// SPDX-License-Identifier: MIT
#include "recorders/spool.h"

#include <algorithm>
#include <cstdio>
#include <new>
#include <utility>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr std::size_t kRoomForSmall_bytes = std::size_t{64} << 20;

std::size_t bytes_of(const SourceEvent& event) {
  if (const auto* bodies = std::get_if<BodyFrame>(&event.data))
    return sizeof(SourceEvent) + bodies->bodies.size() * sizeof(Body);
  if (const auto* depth = std::get_if<DepthFrame>(&event.data)) return depth->depth_mm.size() * 2;
  return sizeof(SourceEvent);
}

bool is_depth(const SourceEvent& event) { return std::holds_alternative<DepthFrame>(event.data); }

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", seconds);
  return text;
}

const FrameStamp* stamp_of(const SourceEvent& event) {
  if (const auto* frame = std::get_if<BodyFrame>(&event.data)) return &frame->stamp;
  if (const auto* frame = std::get_if<DepthFrame>(&event.data)) return &frame->stamp;
  return nullptr;
}

}  // namespace

SessionHeader joint_header(const std::vector<std::unique_ptr<FrameSource>>& sources) {
  SessionHeader header = sources.at(0)->header();
  for (std::size_t i = 1; i < sources.size(); ++i) {
    const SessionHeader& more = sources[i]->header();
    header.simulated = header.simulated || more.simulated;
    if (more.note != header.note) header.note += (header.note.empty() ? "" : "; ") + more.note;
    header.sensors.insert(header.sensors.end(), more.sensors.begin(), more.sensors.end());
  }
  return header;
}

void Spool::Stream::add(const FrameStamp& stamp) {
  // A source that begins anew, or numbers by another clock, has lost nothing by that.
  constexpr std::int64_t kMaxGap = 1'000'000;
  const std::int64_t gap = last_sequence ? stamp.sequence - *last_sequence - 1 : 0;
  if (gap > 0 && gap < kMaxGap) missing += gap;
  last_sequence = stamp.sequence;
  heard = Clock::now();
  ++arrived;
}

Spool::Spool(const std::vector<std::unique_ptr<FrameSource>>& sources, std::shared_ptr<EventLogWriter> log,
             SpoolOptions options)
    : sources_(sources),
      log_(std::make_shared<const std::shared_ptr<EventLogWriter>>(std::move(log))),
      options_(std::move(options)),
      running_sources_(sources.size()) {
  for (const auto& source : sources)
    for (const SensorDescription& sensor : source->header().sensors)
      sensors_.push_back({.description = sensor,
                          .is_live = source->live(),
                          .bodies = {"bodies", true},
                          .depth = {"depth", sensor.has_depth}});
  working_ = sensors_.size();
  try {
    for (std::size_t s = 0; s < sensors_.size(); ++s) threads_.emplace_back([this, s] { work(s); });
    std::size_t first_sensor = 0;
    for (const auto& source : sources) {
      threads_.emplace_back([this, first_sensor, &source] { carry(*source, first_sensor); });
      first_sensor += source->header().sensors.size();
    }
  } catch (const std::exception& error) {  // a thread that cannot be started
    fail(error.what());
    for (std::thread& thread : threads_) thread.join();
    throw;
  }
}

Spool::~Spool() {
  stop();
  for (std::thread& thread : threads_) thread.join();
}

void Spool::stop() {
  for (const auto& source : sources_) source->stop();
}

void Spool::append(std::size_t sensor, const LogEvent& event) {
  HeldLog log;
  {
    const std::lock_guard lock(mutex_);
    log = log_;
  }
  (*log)->append(sensor, event);
}

void Spool::go_on_in(std::shared_ptr<EventLogWriter> log) {
  HeldLog held = std::make_shared<const std::shared_ptr<EventLogWriter>>(std::move(log));
  {
    const std::lock_guard lock(mutex_);
    log_.swap(held);
  }
  while (held.use_count() > 1) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void Spool::set_disk_full(bool full) {
  const std::lock_guard lock(mutex_);
  disk_full_ = full;
}

void Spool::add_exchange(const ClockExchange& exchange) {
  try {
    for (std::size_t s = 0; s < sensors_.size(); ++s) append(s, exchange);
  } catch (const OutputError& error) {
    fail(error.what());
  }
}

void Spool::fail(const std::string& problem) {
  {
    const std::lock_guard lock(mutex_);
    if (log_problem_.empty()) log_problem_ = problem;
  }
  changed_.notify_all();
  stop();
}

void Spool::carry(FrameSource& source, std::size_t first_sensor) {
  std::string problem;
  try {
    while (auto event = source.next()) {
      event->sensor += first_sensor;
      push(std::move(*event), !source.live());
    }
  } catch (const std::exception& error) {
    problem = error.what();
    push({first_sensor, SourceNotice{"the source broke: " + problem}}, false);
  }
  {
    const std::lock_guard lock(mutex_);
    if (source_problem_.empty()) source_problem_ = problem;
    --running_sources_;
    for (std::size_t s = 0; s < source.header().sensors.size(); ++s)
      sensors_[first_sensor + s].has_ended = problem.empty();
  }
  changed_.notify_all();
}

// Counts what came, under the lock; false for what must not reach the log: a torn frame, or a time that no
// clock shows, which would make the whole session unreadable.
bool Spool::arrived(Sensor& sensor, const SourceEvent& event, std::vector<std::string>& notices) {
  if (const auto* exchange = std::get_if<ClockExchange>(&event.data)) return is_plausible(*exchange);
  if (const auto* count = std::get_if<DropCount>(&event.data)) {
    sensor.counted_at_source = count->at_source;
    return false;  // look_after() stores it with what is lost here
  }
  const FrameStamp* stamp = stamp_of(event);
  if (!stamp) return true;
  if (is_torn(event) || !is_plausible(*stamp, sensor.description.tick_ns)) {
    ++sensor.dropped;
    return false;
  }
  Stream& stream = is_depth(event) ? sensor.depth : sensor.bodies;
  if (std::exchange(stream.silent, false))
    notices.push_back(std::string("frames of ") + stream.name + " again");
  stream.add(*stamp);
  return true;
}

void Spool::push(SourceEvent event, bool may_wait) {
  const std::size_t bytes = bytes_of(event), s = event.sensor;
  std::vector<std::string> notices;
  {
    std::unique_lock lock(mutex_);
    Sensor& sensor = sensors_.at(s);
    if (!arrived(sensor, event, notices)) return;
    // an empty queue takes a frame of any size, and what is small has room of its own, so that depth is what
    // a slow disk costs
    const std::size_t limit = options_.limit_bytes + (is_depth(event) ? 0 : kRoomForSmall_bytes);
    const auto has_room = [&] {
      return waiting_bytes_ == 0 || waiting_bytes_ + bytes <= limit || !log_problem_.empty();
    };
    if (may_wait) changed_.wait(lock, has_room);
    if (!has_room() || !log_problem_.empty() || (disk_full_ && stamp_of(event))) {
      ++sensor.dropped;
    } else {
      waiting_bytes_ += bytes;
      sensor.waiting.push_back(std::move(event));
    }
  }
  changed_.notify_all();
  for (const std::string& text : notices) notice(s, text);
}

void Spool::work(std::size_t s) {
  Sensor& sensor = sensors_[s];
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock,
                  [&] { return !sensor.waiting.empty() || running_sources_ == 0 || !log_problem_.empty(); });
    if (!log_problem_.empty() || sensor.waiting.empty()) break;
    SourceEvent event = std::move(sensor.waiting.front());
    sensor.waiting.pop_front();
    const std::size_t bytes = bytes_of(event);
    lock.unlock();
    try {
      store(s, std::move(event));
    } catch (const std::exception& error) {
      fail(error.what());
    }
    lock.lock();
    waiting_bytes_ -= bytes;
    changed_.notify_all();
  }
  --working_;
  changed_.notify_all();
}

void Spool::store(std::size_t s, SourceEvent event) {
  Sensor& sensor = sensors_[s];
  const auto stored = [&](Stream& stream) {
    const std::lock_guard lock(mutex_);
    ++stream.stored;
  };
  if (const auto* frame = std::get_if<BodyFrame>(&event.data)) {
    append(s, *frame);
    stored(sensor.bodies);
    const std::lock_guard lock(mutex_);
    sensor.newest_bodies = *frame;
  } else if (const auto* raw = std::get_if<DepthFrame>(&event.data)) {
    try {
      append(s, encode_depth_frame(raw->stamp, raw->depth_mm, quickest_compression()));
      stored(sensor.depth);
    } catch (const std::bad_alloc&) {
      {
        const std::lock_guard lock(mutex_);
        ++sensor.dropped;
      }
      notice(s, "there was no memory for a depth frame");
    }
  } else if (const auto* exchange = std::get_if<ClockExchange>(&event.data)) {
    append(s, *exchange);
  } else if (const auto* text = std::get_if<SourceNotice>(&event.data)) {
    notice(s, text->text);
  }
}

void Spool::notice(std::size_t s, const std::string& text) {
  try {
    append(s, SensorNotice{host_now_ns(), text});
  } catch (const OutputError& error) {
    fail(error.what());
  }
  const std::lock_guard lock(mutex_);
  constexpr std::size_t kMaxNotices = 1000;  // kept until take_notices() is called
  if (notices_.size() < kMaxNotices) notices_.push_back(sensors_[s].description.name + ": " + text);
}

bool Spool::wait_for_end(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, patience, [&] { return working_ == 0; });
}

void Spool::look_after() {
  std::vector<std::pair<std::size_t, std::string>> notices;
  std::vector<std::pair<std::size_t, DropCount>> drops;
  {
    const std::lock_guard lock(mutex_);
    const auto now = Clock::now();
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      Sensor& sensor = sensors_[s];
      for (Stream* stream : {&sensor.bodies, &sensor.depth}) {
        if (!stream->expected || stream->silent || sensor.has_ended) continue;
        if (std::chrono::duration<double>(now - stream->heard).count() <= options_.silence_s) continue;
        stream->silent = true;
        notices.emplace_back(
            s, std::string("no frame of ") + stream->name + " for " + seconds_text(options_.silence_s));
      }
      const DropCount count{host_now_ns(),
                            std::max(sensor.counted_at_source, sensor.bodies.missing + sensor.depth.missing),
                            sensor.dropped};
      if (count.at_source == sensor.stored_drops.at_source && count.in_queue == sensor.stored_drops.in_queue)
        continue;
      sensor.stored_drops = count;
      drops.emplace_back(s, count);
    }
  }
  try {
    for (const auto& [s, count] : drops) append(s, count);
  } catch (const OutputError& error) {
    fail(error.what());
  }
  for (const auto& [s, text] : notices) notice(s, text);
}

void Spool::count_silence_to_the_end() {
  const std::lock_guard lock(mutex_);
  const auto now = Clock::now();
  for (Sensor& sensor : sensors_) {
    const bool delivered = sensor.bodies.arrived + sensor.depth.arrived > 0;
    for (Stream* stream : {&sensor.bodies, &sensor.depth})
      if (sensor.is_live && stream->expected && stream->silent && (stream->arrived > 0 || !delivered))
        stream->missing += static_cast<std::int64_t>(
            std::chrono::duration<double>(now - stream->heard).count() * sensor.description.nominal_rate_hz);
  }
}

std::vector<SensorStatus> Spool::status(double period_s) {
  const std::lock_guard lock(mutex_);
  std::vector<SensorStatus> all;
  for (Sensor& sensor : sensors_) {
    std::optional<double> slowest_hz;
    for (Stream* stream : {&sensor.bodies, &sensor.depth}) {
      const double rate_hz = static_cast<double>(stream->arrived - stream->at_last_status) / period_s;
      stream->at_last_status = stream->arrived;
      if (stream->expected) slowest_hz = std::min(rate_hz, slowest_hz.value_or(rate_hz));
    }
    all.push_back({sensor.description.name, sensor.bodies.stored, sensor.depth.stored,
                   sensor.stored_drops.at_source, sensor.stored_drops.in_queue, slowest_hz.value_or(0.0),
                   std::exchange(sensor.newest_bodies, {}), sensor.description.intrinsics});
  }
  return all;
}

std::vector<std::string> Spool::take_notices() {
  const std::lock_guard lock(mutex_);
  return std::exchange(notices_, {});
}

std::size_t Spool::waiting_bytes() const {
  const std::lock_guard lock(mutex_);
  return waiting_bytes_;
}

std::uint64_t Spool::frames() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t frames = 0;
  for (const Sensor& sensor : sensors_) frames += sensor.bodies.stored + sensor.depth.stored;
  return frames;
}

std::string Spool::source_problem() const {
  const std::lock_guard lock(mutex_);
  return source_problem_;
}

std::string Spool::log_problem() const {
  const std::lock_guard lock(mutex_);
  return log_problem_;
}

}  // namespace trilat
