// SPDX-License-Identifier: MIT
#include "pipeline/calibration/session_fingerprint.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <type_traits>

#include "datasets/base/content_hash.h"

namespace trilat {
namespace {

constexpr std::uint64_t kDepthFrameEvery = 1200;
constexpr std::uint64_t kStampsAtOnce = 65536;

template <class Rows>
void add_rows(ContentHash& hash, const Rows& rows) {
  static_assert(std::has_unique_object_representations_v<typename Rows::value_type>);
  const std::uint64_t count = rows.size();
  hash.add(&count, sizeof count);
  hash.add(rows.data(), rows.size() * sizeof(typename Rows::value_type));
}

void add_stamps(ContentHash& hash, const SessionReader& session, std::size_t sensor, FrameStream stream,
                std::uint64_t frames) {
  for (std::uint64_t first = 0; first < frames; first += kStampsAtOnce)
    add_rows(hash, session.stamps(sensor, stream, first, std::min(kStampsAtOnce, frames - first)));
}

}  // namespace

std::string fingerprint_of(const SessionReader& session) {
  ContentHash hash;
  add_rows(hash, std::array{std::uint64_t{std::filesystem::file_size(session.path())}});
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    const SensorDescription& sensor = session.header().sensors[s];
    const SensorCounts& counts = session.counts(s);
    for (const std::string& text : {sensor.name, sensor.serial, sensor.source}) add_rows(hash, text);
    add_rows(hash, std::array{sensor.tick_ns, sensor.latency_ns});
    add_rows(hash, std::array{counts.body_frames, counts.depth_frames});
    add_stamps(hash, session, s, FrameStream::bodies, counts.body_frames);
    add_stamps(hash, session, s, FrameStream::depth, counts.depth_frames);
    add_rows(hash, session.clock_exchanges(s));
    for (std::uint64_t frame = 0; frame < counts.depth_frames; frame += kDepthFrameEvery)
      add_rows(hash, session.stored_depth_frame(s, frame).chunk);
  }
  return hash.finish();
}

}  // namespace trilat
