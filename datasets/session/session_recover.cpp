// SPDX-License-Identifier: MIT
#include "datasets/session/session_recover.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/session/session_writer.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBodiesAtOnce = 64;  // frames

// Reports the share done, weighed by frames, and throws when asked to stop.
class ProgressMeter {
 public:
  ProgressMeter(const SessionReader& session, const std::function<bool(double)>& report) : report_(report) {
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

// Takes rows [first, first + count) by `take(first, count)`, in ever smaller parts where it throws; how many
// could not be taken.
std::uint64_t salvage(std::uint64_t first, std::uint64_t count,
                      const std::function<void(std::uint64_t, std::uint64_t)>& take) {
  if (count == 0) return 0;
  try {
    take(first, count);
    return 0;
  } catch (const OutputError&) {
    throw;
  } catch (const InputError&) {
    if (count == 1) return 1;
  }
  return salvage(first, count / 2, take) + salvage(first + count / 2, count - count / 2, take);
}

// All frames, `block` together.
std::uint64_t salvage_all(std::uint64_t frames, std::uint64_t block, ProgressMeter& advance,
                          const std::function<void(std::uint64_t, std::uint64_t)>& take) {
  std::uint64_t damaged = 0;
  for (std::uint64_t first = 0; first < frames; first += block) {
    const std::uint64_t count = std::min(block, frames - first);
    damaged += salvage(first, count, take);
    advance.by(count);
  }
  return damaged;
}

void copy_depth(const SessionReader& from, std::size_t sensor, SessionWriter& to, std::uint64_t index) {
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  const FrameStamp stamp = from.stamps(sensor, FrameStream::depth, index, 1)[0];
  StoredDepthFrame stored = from.stored_depth_frame(sensor, index);
  decode_depth_frame(stored, depth_mm);
  if (stored.compression)
    to.add_depth_frame(sensor, {stamp, std::move(stored.chunk), *stored.compression});
  else
    to.add_depth_frame(sensor, encode_depth_frame(stamp, depth_mm, ChunkCompression::blosc));
}

SensorRecovery copy_sensor(const SessionReader& from, std::size_t sensor, SessionWriter& to,
                           ProgressMeter& advance) {
  const SensorCounts& counts = from.counts(sensor);
  SensorRecovery recovery{from.header().sensors[sensor].name, counts, counts.torn_rows};
  std::uint64_t bodies = 0;
  recovery.damaged_body_frames =
      salvage_all(counts.body_frames, kBodiesAtOnce, advance, [&](std::uint64_t first, std::uint64_t count) {
        for (const BodyFrame& frame : from.body_frames(sensor, first, count)) {
          to.add_body_frame(sensor, frame);
          bodies += frame.bodies.size();
        }
      });
  recovery.damaged_depth_frames =
      salvage_all(counts.depth_frames, 1, advance,
                  [&](std::uint64_t frame, std::uint64_t) { copy_depth(from, sensor, to, frame); });
  recovery.damaged_exchanges =
      salvage(0, counts.clock_exchanges, [&](std::uint64_t first, std::uint64_t count) {
        for (const ClockExchange& exchange : from.clock_exchanges(sensor, first, count))
          to.add_clock_exchange(sensor, exchange);
      });
  recovery.damaged_lists = salvage(0, 1, [&](std::uint64_t, std::uint64_t) {
    for (const DropCount& count : from.drop_counts(sensor)) to.add_drop_count(sensor, count);
  });
  recovery.damaged_lists += salvage(0, 1, [&](std::uint64_t, std::uint64_t) {
    for (const SensorNotice& notice : from.notices(sensor)) to.add_notice(sensor, notice);
  });
  recovery.saved.body_frames -= recovery.damaged_body_frames;
  recovery.damaged_body_frames += std::exchange(recovery.saved.unreadable_body_frames, 0);
  recovery.saved.bodies = bodies;
  recovery.saved.depth_frames -= recovery.damaged_depth_frames;
  recovery.saved.clock_exchanges -= recovery.damaged_exchanges;
  recovery.saved.torn_rows = 0;
  to.add_notice(
      sensor, {0, fmt::format("recovered from a recording that was not closed; left out as damaged: {} body "
                              "frames, {} depth frames, {} clock exchanges, {} lists of notices or drops",
                              recovery.damaged_body_frames, recovery.damaged_depth_frames,
                              recovery.damaged_exchanges, recovery.damaged_lists)});
  return recovery;
}

std::vector<SensorRecovery> copy_session(const SessionReader& from, const std::filesystem::path& output,
                                         ChunkCompression compression,
                                         const std::function<bool(double)>& progress) {
  SessionWriter to(output, from.header(), compression);
  ProgressMeter advance(from, progress);
  std::vector<SensorRecovery> recoveries;
  for (std::size_t s = 0; s < from.header().sensors.size(); ++s)
    recoveries.push_back(copy_sensor(from, s, to, advance));
  to.finish();
  return recoveries;
}

}  // namespace

std::vector<SensorRecovery> recover_session(const std::filesystem::path& damaged,
                                            const std::filesystem::path& output,
                                            const std::function<bool(double)>& progress) {
  check_output_file(output);
  const SessionReader from(damaged);
  ChunkCompression compression = ChunkCompression::blosc;
  for (std::size_t s = 0; s < from.header().sensors.size(); ++s)
    if (from.counts(s).depth_frames > 0) compression = from.counts(s).depth_compression.value_or(compression);
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
