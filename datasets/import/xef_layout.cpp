// SPDX-License-Identifier: MIT
#include "datasets/import/xef_layout.h"

#include <cmath>

#include <fmt/format.h>

#include "datasets/base/byte_file.h"
#include "datasets/import/import_types.h"

namespace trilat::xef {
namespace {

// GUIDs as they lie in a file: the first three fields little-endian.
using Guid = std::array<std::uint8_t, 16>;
constexpr Guid kDepth{0xd6, 0x14, 0x39, 0x0a, 0x16, 0x3b, 0xe1, 0x11,
                      0xaa, 0xc3, 0x00, 0x1e, 0x4f, 0xd5, 0x8c, 0x0f};
constexpr Guid kDepthMonitor{0x5b, 0x41, 0xd9, 0x85, 0xc9, 0x41, 0xf4, 0x47,
                             0x8d, 0xd5, 0x88, 0xc3, 0x04, 0x7b, 0xae, 0x6b};
constexpr Guid kBodies{0x79, 0x51, 0xc4, 0xa0, 0x68, 0x51, 0x75, 0x48,
                       0xa7, 0x5c, 0xf8, 0xf1, 0x76, 0x0f, 0x63, 0x7c};
constexpr Guid kBodiesMonitor{0x4a, 0xb1, 0x32, 0x1c, 0x75, 0x12, 0x6f, 0x49,
                              0xb4, 0x35, 0xf6, 0xf2, 0x2d, 0x45, 0x18, 0x85};
constexpr Guid kRawInfrared{0xe2, 0x14, 0x39, 0x0a, 0x16, 0x3b, 0xe1, 0x11,
                            0xaa, 0xc3, 0x00, 0x1e, 0x4f, 0xd5, 0x8c, 0x0f};

// Within a body frame, and within each of its six bodies.
constexpr std::size_t kFirstBodyAt = 32, kBodyBytes = 1040;
constexpr std::size_t kOrientationsAt = 400, kStatesAt = 800, kIdAt = 1008, kTrackedAt = 1016;
constexpr std::array<std::size_t, 2> kHandsAt{980, 992};  // state, tracking state, confidence

// Raw 0 open, 1 closed, 2 lasso, 3 unknown; the SDK's 0 unknown, 1 not tracked, 2 open, 3 closed, 4 lasso.
std::uint8_t hand_state(std::int32_t raw, std::int32_t tracking) {
  constexpr std::array<std::uint8_t, 4> kSdkState{2, 3, 4, 0};
  if (raw < 0 || raw > 3) throw TornRow{fmt::format("has the hand state {}, which goes from 0 to 3", raw)};
  return tracking == 0 ? std::uint8_t{1} : kSdkState[static_cast<std::size_t>(raw)];
}

Body body_at(std::span<const std::byte> bytes) {
  Body body;
  body.tracking_id = value_at<std::uint64_t>(bytes, kIdAt);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      body.position_m[j][axis] = value_at<float>(bytes, 16 * j + 4 * axis);
    for (std::size_t axis = 0; axis < 4; ++axis)
      body.orientation_xyzw[j][axis] = value_at<float>(bytes, kOrientationsAt + 16 * j + 4 * axis);
    const auto state = value_at<std::int32_t>(bytes, kStatesAt + 4 * j);
    if (state < 0 || state > 2)
      throw TornRow{fmt::format("has the tracking state {}, which goes from 0 to 2", state)};
    body.tracking_state[j] = static_cast<std::uint8_t>(state);
    for (const float x : body.position_m[j])
      if (!std::isfinite(x)) throw TornRow{"has a joint whose position is no number"};
  }
  for (std::size_t hand = 0; hand < 2; ++hand) {
    body.hand_state[hand] = hand_state(value_at<std::int32_t>(bytes, kHandsAt[hand]),
                                       value_at<std::int32_t>(bytes, kHandsAt[hand] + 4));
    body.hand_confidence[hand] = value_at<std::int32_t>(bytes, kHandsAt[hand] + 8) == 1;
  }
  return body;
}

}  // namespace

StreamKind stream_kind(std::span<const std::byte> guid) {
  const auto is = [&](const Guid& known) {
    return std::memcmp(guid.data(), known.data(), known.size()) == 0;
  };
  if (is(kDepth) || is(kDepthMonitor)) return StreamKind::depth;
  if (is(kBodies) || is(kBodiesMonitor)) return StreamKind::bodies;
  return is(kRawInfrared) ? StreamKind::raw_infrared : StreamKind::other;
}

EventHeader event_header(std::span<const std::byte> bytes) {
  return {value_at<std::uint16_t>(bytes, 0), value_at<std::uint16_t>(bytes, 2),
          value_at<std::uint32_t>(bytes, 4), value_at<std::int64_t>(bytes, 8),
          value_at<std::uint32_t>(bytes, 20)};
}

BodyPayload body_payload(std::span<const std::byte> bytes) {
  BodyPayload payload;
  for (std::size_t i = 0; i < 4; ++i) payload.floor_plane[i] = value_at<float>(bytes, 4 * i);
  for (std::size_t b = 0; b < kMaxBodies; ++b) {
    const auto body = bytes.subspan(kFirstBodyAt + kBodyBytes * b, kBodyBytes);
    if (value_at<std::int32_t>(body, kTrackedAt) != 0) payload.bodies.push_back(body_at(body));
  }
  return payload;
}

}  // namespace trilat::xef
