// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "datasets/hdf5/chunk_codec.h"
#include "datasets/rig/depth_camera.h"
#include "datasets/rig/skeleton.h"

namespace trilat {

inline constexpr int kDepthWidth = 512;
inline constexpr int kDepthHeight = 424;
inline constexpr std::size_t kDepthPixels = std::size_t{kDepthWidth} * kDepthHeight;
inline constexpr int kMaxBodies = 6;           // slots of the Kinect SDK
inline constexpr int kMaxSessionSensors = 64;  // a session with more is not believed

// One sensor of a session. `name` is the key that calibration files use; `tick_ns` the length of a device
// tick (100 for the Kinect SDK).
struct SensorDescription {
  std::string name;
  std::string serial;
  std::string model = "Kinect v2";
  std::string source;  // "simulated", "kinect-sdk", an import format
  DepthIntrinsics intrinsics;
  std::int64_t tick_ns = 100;
  double nominal_rate_hz = 30.0;
  std::int64_t latency_ns = 0;  // stated time from exposure to arrival; 0 when unknown
  bool has_depth = false;
};

// When a frame was made and when it came: device ticks as the sensor gave them, arrival on the monotonic
// clock of the machine it arrived at.
struct FrameStamp {
  std::int64_t sequence = 0;
  std::int64_t device_ticks = 0;
  std::int64_t arrival_ns = 0;
};

// One body as the tracker delivered it: camera space, metres; orientations x, y, z, w.
struct Body {
  std::uint64_t tracking_id = 0;
  std::array<std::array<float, 3>, kJointCount> position_m{};
  std::array<std::array<float, 4>, kJointCount> orientation_xyzw{};
  std::array<std::uint8_t, kJointCount> tracking_state{};
  std::array<std::uint8_t, 2> hand_state{};       // left, right; the SDK's HandState
  std::array<std::uint8_t, 2> hand_confidence{};  // 0 low, 1 high
};

struct BodyFrame {
  FrameStamp stamp;
  std::array<float, 4> floor_plane{};  // unit normal and height in metres; all zero when no floor was seen
  std::vector<Body> bodies;
};

// The four stamps of a clock exchange: server sends (t1), agent receives (t2) and answers (t3), server
// receives (t4). t1 and t4 on the host clock of the recording, t2 and t3 on the clock that stamps this
// sensor's arrivals.
struct ClockExchange {
  std::int64_t t1_ns = 0;
  std::int64_t t2_ns = 0;
  std::int64_t t3_ns = 0;
  std::int64_t t4_ns = 0;
};

// Running totals of lost frames at one moment (host clock).
struct DropCount {
  std::int64_t host_ns = 0;
  std::int64_t at_source = 0;
  std::int64_t in_queue = 0;
};

// A recorder stores no more notices of a sensor, and a reader reads no more.
inline constexpr std::uint64_t kMaxSessionNotices = std::uint64_t{1} << 16;

// Message about a sensor for a person: unplugged, silent, back again.
struct SensorNotice {
  std::int64_t host_ns = 0;
  std::string text;
};

struct SessionHeader {
  bool simulated = false;
  std::string started_utc;  // free text, for people
  std::string note;
  std::vector<SensorDescription> sensors;
};

// One depth frame ready for the file. Made by encode_depth_frame() on any thread.
struct EncodedDepthFrame {
  FrameStamp stamp;
  std::vector<std::byte> chunk;
  ChunkCompression compression = ChunkCompression::blosc;
};

// `depth_mm` holds kDepthPixels values, row by row, exactly as received; 0 is invalid.
EncodedDepthFrame encode_depth_frame(const FrameStamp& stamp, std::span<const std::uint16_t> depth_mm,
                                     ChunkCompression compression);

// Why a reader of sessions would not believe this sensor; empty where it would.
std::string problem_with(const SensorDescription& sensor);

// Whether a reader would believe these times: within 18 years of their clock's origin, exchanges within 9.
bool is_plausible(const FrameStamp& stamp, std::int64_t tick_ns);
bool is_plausible(const ClockExchange& exchange);

}  // namespace trilat
