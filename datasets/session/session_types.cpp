// SPDX-License-Identifier: MIT
#include "datasets/session/session_types.h"

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr std::int64_t kMaxStamp_ns = std::int64_t{1} << 59;
constexpr std::int64_t kMaxExchange_ns = std::int64_t{1} << 58;

bool within(std::int64_t value, std::int64_t most) { return value >= -most && value <= most; }

}  // namespace

EncodedDepthFrame encode_depth_frame(const FrameStamp& stamp, std::span<const std::uint16_t> depth_mm,
                                     ChunkCompression compression) {
  TRILAT_CHECK(depth_mm.size() == kDepthPixels, "a depth frame has 512 x 424 pixels");
  return {stamp, encode_chunk(std::as_bytes(depth_mm), 2, compression), compression};
}

std::string problem_with(const SensorDescription& sensor) {
  if (sensor.tick_ns < 1 || sensor.tick_ns > 1'000'000'000)
    return "has a device tick outside 1 to 1000000000 ns";
  if (!(sensor.nominal_rate_hz > 0.1 && sensor.nominal_rate_hz < 10'000.0))
    return "has a frame rate outside 0.1 to 10000 Hz";
  return problem_with(sensor.intrinsics);
}

bool is_plausible(const FrameStamp& stamp, std::int64_t tick_ns) {
  return within(stamp.device_ticks, kMaxStamp_ns / tick_ns) && within(stamp.arrival_ns, kMaxStamp_ns);
}

bool is_plausible(const ClockExchange& e) {
  return within(e.t1_ns, kMaxExchange_ns) && within(e.t2_ns, kMaxExchange_ns) &&
         within(e.t3_ns, kMaxExchange_ns) && within(e.t4_ns, kMaxExchange_ns);
}

}  // namespace trilat
