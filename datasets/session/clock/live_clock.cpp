// SPDX-License-Identifier: MIT
#include "datasets/session/clock/live_clock.h"

#include <algorithm>

namespace trilat {

LiveClock::LiveClock(std::span<const ClockExchange> exchanges) {
  for (const ClockExchange& e : exchanges)
    exchanges_.push_back({{e.t3_ns},
                          {(e.t4_ns - e.t1_ns) - (e.t3_ns - e.t2_ns)},
                          {((e.t1_ns - e.t2_ns) + (e.t4_ns - e.t3_ns)) / 2}});
  std::ranges::stable_sort(exchanges_, {}, &Known::answered);
}

HostTime LiveClock::operator()(AgentTime t) const {
  constexpr std::ptrdiff_t kRecent = 8;
  if (exchanges_.empty()) return {t.ns};
  const auto end =
      std::max(exchanges_.begin() + 1, std::ranges::upper_bound(exchanges_, t, {}, &Known::answered));
  const auto first = end - std::min(kRecent, end - exchanges_.begin());
  return {t.ns + std::ranges::min_element(first, end, {}, &Known::delay)->host_minus_agent.ns};
}

}  // namespace trilat
