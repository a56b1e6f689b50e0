// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "datasets/session/session_types.h"

namespace trilat {

// Time that an exchange spent on the wire, both ways.
inline std::int64_t delay_ns(const ClockExchange& e) { return (e.t4_ns - e.t1_ns) - (e.t3_ns - e.t2_ns); }

// False when it was answered before it was sent, or took longer to answer than it was away.
inline bool runs_forwards(const ClockExchange& e) {
  return e.t4_ns >= e.t1_ns && e.t3_ns >= e.t2_ns && delay_ns(e) >= 0;
}

// Exchanges by t1, parted where the agent's clock was set, or its machine restarted: whatever the delays, the
// agent's clock is ahead of the host's by t3 - t4 at least and t2 - t1 at most, so exchanges whose spans do
// not meet belong to different settings of the clock. Three in a row make a new one; fewer contradict the
// rest and are left out.
struct ExchangeSegments {
  std::vector<std::vector<ClockExchange>> segments;
  std::size_t backwards = 0;
  std::size_t contradicting = 0;
};
ExchangeSegments split_exchanges(std::span<const ClockExchange> exchanges);

}  // namespace trilat
