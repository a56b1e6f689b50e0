// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "datasets/session/session_types.h"

// The layout of Kinect Studio's .xef as far as it is known: nobody has published it, so it was found by
// looking at files. Little-endian.
namespace trilat::xef {

inline constexpr std::array<char, 8> kMagic{'E', 'V', 'E', 'N', 'T', 'S', '1', '\0'};
inline constexpr std::uint64_t kFileHeaderBytes = 24;
inline constexpr std::uint64_t kStreamCountAt = 12;  // i32: streams + 1, or 0 when it was not filled in
inline constexpr std::uint64_t kEventHeaderBytes = 24;

inline constexpr std::uint16_t kCompressed = 1;  // of an event's flags
inline constexpr std::uint16_t kIndexBlock =
    0xFFFF;  // a stream number that stands for a block of the file's index
inline constexpr std::array<std::uint64_t, 3> kIndexBlockBytes{0x6000, 0x7000, 0xC000};

// The first two events of a stream describe it.
inline constexpr std::uint64_t kDescriptionTagBytes = 24;
inline constexpr std::uint32_t kNameEventBytes = 292;
inline constexpr std::uint32_t kGuidEventBytes = 98;
inline constexpr std::size_t kDataTypeAt = 4;   // in the name event's tag: GUID
inline constexpr std::size_t kTagSizeAt = 258;  // in the name event's data: u16
inline constexpr std::uint64_t kCompressedNameExtraBytes = 8;

inline constexpr std::uint32_t kDepthBytes = 2 * kDepthPixels;
inline constexpr std::uint32_t kBodyFrameBytes = 6288;
inline constexpr std::uint32_t kLargestEventBytes = 64u << 20;
inline constexpr std::uint64_t kFooterBytes = 0x6B0;

enum class StreamKind { depth, bodies, raw_infrared, other };
StreamKind stream_kind(std::span<const std::byte> guid);  // 16 bytes

struct EventHeader {
  std::uint16_t stream = 0;
  std::uint16_t flags = 0;
  std::uint32_t stored_bytes = 0;
  std::int64_t ticks = 0;  // 100 ns
  std::uint32_t full_bytes = 0;
};
EventHeader event_header(std::span<const std::byte> bytes);

// The tracked bodies and the floor of a body frame of kBodyFrameBytes; TornRow for states that cannot be.
struct BodyPayload {
  std::array<float, 4> floor_plane{};
  std::vector<Body> bodies{};
};
BodyPayload body_payload(std::span<const std::byte> bytes);

}  // namespace trilat::xef
