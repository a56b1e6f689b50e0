// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace trilat {

// The type byte of a message. Never reused for anything else.
enum class WireType : std::uint8_t {
  hello = 1,
  welcome = 2,
  refusal = 3,
  resume = 4,
  body_frame = 5,
  depth_frame = 6,
  notice = 7,
  drop_count = 8,
  ack = 9,
  alive = 10,
  clock_ping = 11,
  clock_pong = 12,
  bye = 13,
};

// First in every hello, so that a stranger is recognised whatever it speaks.
inline constexpr std::uint32_t kWireMagic = 0x4c495254;  // "TRIL"

}  // namespace trilat
