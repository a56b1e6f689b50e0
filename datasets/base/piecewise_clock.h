// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <vector>

#include "datasets/base/time.h"

namespace trilat {

// ClockMaps one after another, each from an instant on; the first also holds before its own. Without any,
// both clocks read the same.
template <class To, class From>
struct PiecewiseClock {
  struct Piece {
    Instant<From> from;
    ClockMap<To, From> map;
  };
  std::vector<Piece> pieces;

  Instant<To> operator()(Instant<From> t) const {
    if (pieces.empty()) return {t.ns};
    const auto after = std::upper_bound(pieces.begin() + 1, pieces.end(), t,
                                        [](Instant<From> at, const Piece& piece) { return at < piece.from; });
    return std::prev(after)->map(t);
  }
};

// One reading of two clocks.
template <class To, class From>
struct ClockKnot {
  Instant<From> from;
  Instant<To> to;
};

template <class To, class From>
PiecewiseClock<To, From> along(const ClockMap<To, From>& line) {
  return {{{line.origin_from, line}}};
}

// Straight from knot to knot, and with the drift of `line` before the first and after the last. Knots must
// rise; without knots it is the line.
template <class To, class From>
PiecewiseClock<To, From> through(const std::vector<ClockKnot<To, From>>& knots,
                                 const ClockMap<To, From>& line) {
  if (knots.empty()) return along(line);
  PiecewiseClock<To, From> clock;
  clock.pieces.push_back({knots.front().from, {knots.front().from, knots.front().to, line.drift}});
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const Duration from = knots[k + 1].from - knots[k].from, to = knots[k + 1].to - knots[k].to;
    clock.pieces.push_back(
        {knots[k].from,
         {knots[k].from, knots[k].to, static_cast<double>((to - from).ns) / static_cast<double>(from.ns)}});
  }
  clock.pieces.push_back({knots.back().from, {knots.back().from, knots.back().to, line.drift}});
  return clock;
}

}  // namespace trilat
