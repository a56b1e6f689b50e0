// SPDX-License-Identifier: MIT
#include "recorders/replay_source.h"

#include <algorithm>
#include <limits>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 256;  // frames whose stamps are read together

std::optional<std::int64_t> first_arrival(const SessionReader& session, std::size_t sensor) {
  std::optional<std::int64_t> first;
  const SensorCounts& counts = session.counts(sensor);
  for (const auto& [stream, frames] : {std::pair{FrameStream::bodies, counts.body_frames},
                                       std::pair{FrameStream::depth, counts.depth_frames}})
    if (frames > 0) {
      const std::int64_t arrival = session.stamps(sensor, stream, 0, 1)[0].arrival_ns;
      first = std::min(first.value_or(arrival), arrival);
    }
  return first;
}

}  // namespace

ReplaySource::ReplaySource(const std::filesystem::path& session) : session_(session) {
  for (std::size_t s = 0; s < session_.header().sensors.size(); ++s) {
    Stream stream;
    stream.sensor = s;
    const auto exchanges = session_.clock_exchanges(s);
    stream.exchanges.assign(exchanges.begin(), exchanges.end());
    stream.first_arrival_ns = first_arrival(session_, s).value_or(0);
    if (!exchanges.empty()) stream.first_exchange_ns = exchanges.front().t1_ns;
    streams_.push_back(std::move(stream));
  }
}

std::int64_t ReplaySource::origin_ns() const {
  std::int64_t origin = std::numeric_limits<std::int64_t>::max();
  for (std::size_t s = 0; s < streams_.size(); ++s) {
    if (!streams_[s].exchanges.empty())
      origin = std::min(origin, streams_[s].first_exchange_ns);
    else if (const auto first = first_arrival(session_, s))
      origin = std::min(origin, *first);
  }
  return origin == std::numeric_limits<std::int64_t>::max() ? 0 : origin;
}

void ReplaySource::fill(Stream& stream) const {
  const SensorCounts& counts = session_.counts(stream.sensor);
  if (stream.bodies.empty() && stream.next_body < counts.body_frames) {
    const std::uint64_t count = std::min(kBlock, counts.body_frames - stream.next_body);
    auto frames = session_.body_frames(stream.sensor, stream.next_body, count);
    stream.bodies.assign(std::make_move_iterator(frames.begin()), std::make_move_iterator(frames.end()));
    stream.next_body += count;
  }
  if (stream.depth_stamps.empty() && stream.next_depth < counts.depth_frames) {
    const std::uint64_t count = std::min(kBlock, counts.depth_frames - stream.next_depth);
    const auto stamps = session_.stamps(stream.sensor, FrameStream::depth, stream.next_depth, count);
    stream.depth_stamps.assign(stamps.begin(), stamps.end());
  }
}

std::optional<ReplaySource::Due> ReplaySource::due_of(const Stream& stream) const {
  std::optional<Due> due;
  const auto earliest = [&](std::int64_t at_ns, int kind) {
    if (!due || at_ns < due->at_ns) due = Due{at_ns, kind};
  };
  if (!stream.exchanges.empty()) earliest(stream.exchanges.front().t4_ns - stream.first_exchange_ns, 0);
  if (!stream.bodies.empty()) earliest(stream.bodies.front().stamp.arrival_ns - stream.first_arrival_ns, 1);
  if (!stream.depth_stamps.empty())
    earliest(stream.depth_stamps.front().arrival_ns - stream.first_arrival_ns, 2);
  return due;
}

SourceEvent ReplaySource::take(Stream& stream, int kind) {
  const auto pop = [](auto& queue) {
    auto front = std::move(queue.front());
    queue.pop_front();
    return front;
  };
  if (kind == 0) return {stream.sensor, pop(stream.exchanges)};
  if (kind == 1) return {stream.sensor, pop(stream.bodies)};
  const FrameStamp stamp = pop(stream.depth_stamps);
  const std::uint64_t index = stream.next_depth++;
  StoredDepthFrame stored = session_.stored_depth_frame(stream.sensor, index);
  if (stored.compression)
    return {stream.sensor, EncodedDepthFrame{stamp, std::move(stored.chunk), *stored.compression}};
  DepthFrame raw{stamp, std::vector<std::uint16_t>(kDepthPixels)};
  decode_depth_frame(stored, raw.depth_mm);
  return {stream.sensor, std::move(raw)};
}

std::optional<SourceEvent> ReplaySource::next() {
  Stream* behind = nullptr;
  Due first;
  for (Stream& stream : streams_) {
    fill(stream);
    const auto due = due_of(stream);
    if (due && (!behind || due->at_ns < first.at_ns)) {
      behind = &stream;
      first = *due;
    }
  }
  if (!behind) return std::nullopt;
  return take(*behind, first.kind);
}

}  // namespace trilat
