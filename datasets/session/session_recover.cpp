// SPDX-License-Identifier: MIT
#include "datasets/session/session_recover.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/session/session_writer.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 64;  // frames between flushes; 30 MB of depth

// Reports the share done, weighed by frames, and throws when asked to stop.
class Advance {
 public:
  Advance(const SessionReader& session, const std::function<bool(double)>& report) : report_(report) {
    for (std::size_t s = 0; s < session.header().sensors.size(); ++s)
      total_ += session.counts(s).body_frames + session.counts(s).depth_frames;
  }
  void by(std::uint64_t frames) {
    done_ += frames;
    if (report_ && !report_(static_cast<double>(done_) / static_cast<double>(total_))) throw Interrupted();
  }

 private:
  const std::function<bool(double)>& report_;
  std::uint64_t total_ = 1, done_ = 0;
};

void copy_bodies(const SessionReader& from, std::size_t sensor, SessionWriter& to, Advance& advance) {
  const std::uint64_t frames = from.counts(sensor).body_frames;
  for (std::uint64_t first = 0; first < frames; first += kBlock) {
    const std::uint64_t count = std::min(kBlock, frames - first);
    for (const BodyFrame& frame : from.body_frames(sensor, first, count)) to.add_body_frame(sensor, frame);
    to.flush();
    advance.by(count);
  }
}

// A frame as it goes into the new file; nothing when it is damaged.
std::optional<EncodedDepthFrame> saved_frame(const SessionReader& from, std::size_t sensor,
                                             std::uint64_t index, const FrameStamp& stamp,
                                             ChunkCompression compression,
                                             std::vector<std::uint16_t>& depth_mm) {
  try {
    StoredDepthFrame stored = from.stored_depth_frame(sensor, index);
    decode_depth_frame(stored, depth_mm);
    if (stored.compression == compression)
      return EncodedDepthFrame{stamp, std::move(stored.chunk), compression};
    return encode_depth_frame(stamp, depth_mm, compression);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

std::uint64_t copy_depth(const SessionReader& from, std::size_t sensor, ChunkCompression compression,
                         SessionWriter& to, Advance& advance) {
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  const std::uint64_t frames = from.counts(sensor).depth_frames;
  std::uint64_t damaged = 0;
  for (std::uint64_t first = 0; first < frames; first += kBlock) {
    const std::uint64_t count = std::min(kBlock, frames - first);
    const std::vector<FrameStamp> stamps = from.stamps(sensor, FrameStream::depth, first, count);
    for (std::uint64_t i = 0; i < count; ++i) {
      const auto frame = saved_frame(from, sensor, first + i, stamps[i], compression, depth_mm);
      if (frame)
        to.add_depth_frame(sensor, *frame);
      else
        ++damaged;
    }
    to.flush();
    advance.by(count);
  }
  return damaged;
}

SensorRecovery copy_sensor(const SessionReader& from, std::size_t sensor, ChunkCompression compression,
                           SessionWriter& to, Advance& advance) {
  SensorRecovery recovery{from.header().sensors[sensor].name, from.counts(sensor),
                          from.counts(sensor).torn_rows, 0};
  copy_bodies(from, sensor, to, advance);
  if (from.header().sensors[sensor].has_depth)
    recovery.damaged_depth_frames = copy_depth(from, sensor, compression, to, advance);
  for (const ClockExchange& exchange : from.clock_exchanges(sensor)) to.add_clock_exchange(sensor, exchange);
  for (const DropCount& count : from.drop_counts(sensor)) to.add_drop_count(sensor, count);
  for (const SensorNotice& notice : from.notices(sensor)) to.add_notice(sensor, notice);
  recovery.saved.depth_frames -= recovery.damaged_depth_frames;
  recovery.saved.torn_rows = 0;
  if (!from.complete())
    to.add_notice(sensor, {0, fmt::format("recovered from a recording that was not closed; {} damaged depth "
                                          "frames were left out",
                                          recovery.damaged_depth_frames)});
  to.flush();
  return recovery;
}

std::vector<SensorRecovery> copy_session(const SessionReader& from, const std::filesystem::path& output,
                                         ChunkCompression compression,
                                         const std::function<bool(double)>& progress) {
  SessionWriter to(output, from.header(), compression);
  Advance advance(from, progress);
  std::vector<SensorRecovery> recoveries;
  for (std::size_t s = 0; s < from.header().sensors.size(); ++s)
    recoveries.push_back(copy_sensor(from, s, compression, to, advance));
  to.finish();
  return recoveries;
}

}  // namespace

std::vector<SensorRecovery> recover_session(const std::filesystem::path& damaged,
                                            const std::filesystem::path& output,
                                            const std::function<bool(double)>& progress) {
  if (std::filesystem::exists(output))
    throw InputError(output.string(), "exists; what is recovered needs a name of its own");
  check_output_file(output);
  const SessionReader from(damaged);
  ChunkCompression compression = ChunkCompression::blosc;
  for (std::size_t s = 0; s < from.header().sensors.size(); ++s)
    if (from.counts(s).depth_frames > 0)
      compression = from.stored_depth_frame(s, 0).compression.value_or(compression);
  // beside `output`, whose own unfinished name may be the damaged file's
  const std::filesystem::path beside = output.string() + ".recovered";
  std::vector<SensorRecovery> recoveries;
  try {
    recoveries = copy_session(from, beside, compression, progress);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(partial_name(beside), ignored);
    throw;
  }
  publish_file(beside, output);
  return recoveries;
}

}  // namespace trilat
