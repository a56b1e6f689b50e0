// SPDX-License-Identifier: MIT
#include "recorders/capture_store.h"

#include <algorithm>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "recorders/steady_time.h"

namespace trilat {

CaptureStore::CaptureStore(SessionWriter& writer, const SessionHeader& header, const CaptureOptions& options)
    : writer_(writer),
      options_(options),
      heard_(header.sensors.size(), Clock::now()),
      silent_(header.sensors.size(), false),
      lost_on_the_way_(header.sensors.size(), 0),
      at_last_status_(header.sensors.size(), 0) {
  for (const SensorDescription& sensor : header.sensors) status_.push_back({.name = sensor.name});
}

void CaptureStore::add(const SourceEvent& event) {
  const std::size_t s = event.sensor;
  SensorStatus& status = status_.at(s);
  if (const auto* frame = std::get_if<BodyFrame>(&event.data)) {
    heard(s);
    writer_.add_body_frame(s, *frame);
    ++status.body_frames;
    if (options_.on_bodies) options_.on_bodies(status.name, *frame);
  } else if (const auto* depth = std::get_if<EncodedDepthFrame>(&event.data)) {
    heard(s);
    writer_.add_depth_frame(s, *depth);
    ++status.depth_frames;
    if (options_.on_depth_stored) options_.on_depth_stored(depth->stamp);
  } else if (const auto* exchange = std::get_if<ClockExchange>(&event.data)) {
    writer_.add_clock_exchange(s, *exchange);
  } else if (const auto* count = std::get_if<DropCount>(&event.data)) {
    status.lost_at_source = count->at_source;
    status.lost_in_queue += count->in_queue - lost_on_the_way_[s];
    lost_on_the_way_[s] = count->in_queue;
    writer_.add_drop_count(s, {count->host_ns, count->at_source, status.lost_in_queue});
  } else if (const auto* text = std::get_if<SourceNotice>(&event.data)) {
    notice(s, text->text);
  } else {
    TRILAT_CHECK(false, "depth leaves the queue compressed");
  }
}

void CaptureStore::notice(std::size_t sensor, const std::string& text) {
  writer_.add_notice(sensor, {steady_now_ns(), text});
  if (options_.on_notice) options_.on_notice(status_.at(sensor).name, text);
}

void CaptureStore::heard(std::size_t sensor) {
  heard_[sensor] = Clock::now();
  if (!silent_[sensor]) return;
  silent_[sensor] = false;
  notice(sensor, "frames again");
}

void CaptureStore::look_for_silence(Clock::time_point now) {
  const std::chrono::duration<double> limit(options_.silence_s);
  for (std::size_t s = 0; s < status_.size(); ++s)
    if (!silent_[s] && now - heard_[s] > limit) {
      silent_[s] = true;
      notice(s, fmt::format("no frame for {:.1f} s", options_.silence_s));
    }
}

void CaptureStore::note_drops(const CaptureQueue& queue) {
  for (std::size_t s = 0; s < status_.size(); ++s) {
    const std::int64_t dropped = queue.dropped(s) + lost_on_the_way_[s];
    if (dropped == status_[s].lost_in_queue) continue;
    status_[s].lost_in_queue = dropped;
    writer_.add_drop_count(s, {steady_now_ns(), status_[s].lost_at_source, dropped});
  }
}

std::vector<SensorStatus> CaptureStore::status(double period_s) {
  for (std::size_t s = 0; s < status_.size(); ++s) {
    const std::uint64_t frames = std::max(status_[s].body_frames, status_[s].depth_frames);
    status_[s].rate_hz = static_cast<double>(frames - at_last_status_[s]) / period_s;
    at_last_status_[s] = frames;
  }
  return status_;
}

}  // namespace trilat
