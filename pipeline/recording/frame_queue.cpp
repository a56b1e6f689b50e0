// SPDX-License-Identifier: MIT
#include "pipeline/recording/frame_queue.h"

#include <algorithm>
#include <cmath>

namespace trilat {
namespace {

// The beginning of the server's first frame not before `received_ns`.
std::int64_t next_server_frame_ns(std::int64_t received_ns, std::int64_t length_ns) {
  if (length_ns == 0) return received_ns;
  return (received_ns + length_ns - 1) / length_ns * length_ns;
}

}  // namespace

QueueCounts run_queue(const std::vector<TrialFrame>& frames, const std::vector<double>& errors_s,
                      const QueueRule& rule) {
  QueueCounts counts;
  std::int64_t free_ns = 0;  // when the server can take the next one
  for (std::size_t f = 0; f < frames.size(); ++f) {
    ++counts.came;
    if (!std::isfinite(errors_s[f])) {
      ++counts.untimed;
      continue;
    }
    const std::int64_t now_ns =
        std::max(free_ns, next_server_frame_ns(frames[f].received.ns, rule.server_frame.ns));
    const std::int64_t age_ns = now_ns - frames[f].sent.ns - duration_from_s(errors_s[f]).ns;
    if (age_ns > rule.late.ns) {
      ++counts.too_late;
    } else if (age_ns < -rule.late.ns) {
      ++counts.too_early;
    } else {
      ++counts.taken;
      free_ns = now_ns + rule.server_frame.ns;
    }
  }
  return counts;
}

}  // namespace trilat
