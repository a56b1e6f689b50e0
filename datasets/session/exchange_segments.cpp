// SPDX-License-Identifier: MIT
#include "datasets/session/exchange_segments.h"

#include <algorithm>

namespace trilat {
namespace {

constexpr double kFastestChange = 1e-2;  // of one clock against another: far beyond any crystal
constexpr std::int64_t kTolerance_ns = 1'000'000;
constexpr std::size_t kFewest = 3;

// Where agent - host can lie, after all that one setting of the clock has said so far.
class Corridor {
 public:
  explicit Corridor(const ClockExchange& e)
      : host_ns_(e.t1_ns), least_ns_(e.t3_ns - e.t4_ns), most_ns_(e.t2_ns - e.t1_ns) {}

  // Narrows it when the exchange fits.
  bool admits(const ClockExchange& e) {
    const auto wander = static_cast<std::int64_t>(kFastestChange * static_cast<double>(e.t1_ns - host_ns_));
    const std::int64_t least_ns = std::max(least_ns_ - wander, e.t3_ns - e.t4_ns);
    const std::int64_t most_ns = std::min(most_ns_ + wander, e.t2_ns - e.t1_ns);
    if (least_ns > most_ns + kTolerance_ns) return false;
    host_ns_ = e.t1_ns;
    least_ns_ = std::min(least_ns, most_ns);
    most_ns_ = std::max(least_ns, most_ns);
    return true;
  }

 private:
  std::int64_t host_ns_, least_ns_, most_ns_;
};

std::vector<ClockExchange> forwards_by_time(std::span<const ClockExchange> exchanges) {
  std::vector<ClockExchange> sound;
  std::copy_if(exchanges.begin(), exchanges.end(), std::back_inserter(sound), runs_forwards);
  std::stable_sort(sound.begin(), sound.end(),
                   [](const auto& a, const auto& b) { return a.t1_ns < b.t1_ns; });
  return sound;
}

// Segments of one or two say nothing once there are longer ones.
void drop_fragments(ExchangeSegments& split) {
  const bool any_long = std::any_of(split.segments.begin(), split.segments.end(),
                                    [](const auto& s) { return s.size() >= kFewest; });
  if (!any_long) return;
  std::erase_if(split.segments, [&](const auto& s) {
    if (s.size() >= kFewest) return false;
    split.contradicting += s.size();
    return true;
  });
}

}  // namespace

ExchangeSegments split_exchanges(std::span<const ClockExchange> exchanges) {
  ExchangeSegments split;
  const std::vector<ClockExchange> sound = forwards_by_time(exchanges);
  split.backwards = exchanges.size() - sound.size();
  if (sound.empty()) return split;
  std::vector<Corridor> corridor{Corridor(sound.front())}, other_corridor;
  std::vector<ClockExchange> other;  // agree with each other, and not with the segment
  split.segments.push_back({sound.front()});
  for (std::size_t i = 1; i < sound.size(); ++i) {
    if (corridor.back().admits(sound[i])) {
      split.segments.back().push_back(sound[i]);
      split.contradicting += other.size();
      other.clear();
      continue;
    }
    if (other.empty() || !other_corridor.back().admits(sound[i])) {
      split.contradicting += other.size();
      other.clear();
      other_corridor.assign(1, Corridor(sound[i]));
    }
    other.push_back(sound[i]);
    if (other.size() < kFewest) continue;
    split.segments.push_back(std::move(other));
    corridor = other_corridor;
    other.clear();
  }
  split.contradicting += other.size();
  drop_fragments(split);
  return split;
}

}  // namespace trilat
