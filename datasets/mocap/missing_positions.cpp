// SPDX-License-Identifier: MIT
#include "datasets/mocap/missing_positions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "datasets/base/median.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using Positions = std::vector<Vector3d>;

const Vector3d kNone = Vector3d::Constant(kNaN);

void remove_marked(Positions& position_m, MissingCounts& counts) {
  for (Vector3d& p : position_m) {
    const bool at_origin = p.isZero(0.0), is_filled = std::isinf(p.x());
    counts.at_origin += at_origin;
    counts.filled += is_filled;
    if (at_origin || is_filled) p = kNone;
  }
}

// Removes one value of three equal numbers, such as (-1, -1, -1), to and from which points jump again and
// again.
void remove_equal_numbers(std::vector<Positions>& position_m, std::vector<MissingCounts>& counts) {
  constexpr double kMinJump_m = 0.3;
  constexpr std::size_t kMinRepeats = 3;
  struct Run {
    std::size_t asset, first, end;
  };
  std::map<double, std::vector<Run>> runs;
  std::map<double, std::size_t> repeats;
  for (std::size_t a = 0; a < position_m.size(); ++a) {
    const Positions& own = position_m[a];
    const auto is_jump = [&](std::size_t one, std::size_t next) {
      return !own[one].allFinite() || !own[next].allFinite() || (own[one] - own[next]).norm() > kMinJump_m;
    };
    for (std::size_t first = 0, end = 0; first < own.size(); first = end) {
      end = first + 1;
      if (own[first].x() != own[first].y() || own[first].y() != own[first].z()) continue;
      while (end < own.size() && own[end] == own[first]) ++end;
      const bool is_all = first == 0 && end == own.size();
      if (is_all || (first > 0 && !is_jump(first - 1, first)) || (end < own.size() && !is_jump(end - 1, end)))
        continue;
      runs[own[first].x()].push_back({a, first, end});
      repeats[own[first].x()] += end - first;
    }
  }
  for (const auto& [value, of_value] : runs)
    for (const Run& run : of_value)
      for (std::size_t f = run.first; f < run.end && repeats[value] >= kMinRepeats; ++f) {
        position_m[run.asset][f] = kNone;
        ++counts[run.asset].filled;
      }
}

void remove_fill_values(std::vector<Positions>& position_m, std::vector<MissingCounts>& counts) {
  constexpr std::size_t kSample = 20'000;  // positions that median and radius are estimated from
  constexpr double kMinRadius_m = 3.0, kRadii = 4.0;
  constexpr int kMinRepeats = 3;
  std::size_t all = 0, seen = 0;
  for (const Positions& positions : position_m) all += positions.size();
  const std::size_t step = 1 + all / kSample;
  std::array<std::vector<double>, 3> axes;
  for (const Positions& positions : position_m)
    for (const Vector3d& p : positions)
      if (++seen % step == 0 && p.allFinite())
        for (int axis = 0; axis < 3; ++axis) axes[static_cast<std::size_t>(axis)].push_back(p[axis]);
  if (axes[0].empty()) return;
  std::vector<double> distance_m(axes[0].size());
  const Vector3d median_m(upper_median(axes[0]), upper_median(axes[1]), upper_median(axes[2]));
  for (std::size_t i = 0; i < distance_m.size(); ++i)
    distance_m[i] = (Vector3d(axes[0][i], axes[1][i], axes[2][i]) - median_m).norm();
  const double radius_m = std::max(kMinRadius_m, kRadii * upper_median(distance_m));
  const auto is_far = [&](const Vector3d& p) { return (p - median_m).norm() > radius_m; };
  std::map<std::array<double, 3>, int> repeats;
  for (const Positions& positions : position_m)
    for (const Vector3d& p : positions)
      if (is_far(p)) ++repeats[{p.x(), p.y(), p.z()}];
  for (std::size_t a = 0; a < position_m.size(); ++a)
    for (Vector3d& p : position_m[a])
      if (is_far(p) && repeats[{p.x(), p.y(), p.z()}] >= kMinRepeats) {
        p = kNone;
        ++counts[a].filled;
      }
}

// How an asset steps from one frame to the next, where it is known in both.
struct Steps {
  std::int64_t count = 0, zero = 0;
  double median_m = 0.0;
};

Steps steps_of(const Positions& position_m) {
  Steps steps;
  std::vector<double> lengths_m;
  lengths_m.reserve(position_m.size());
  for (std::size_t f = 1; f < position_m.size(); ++f) {
    if (!position_m[f].allFinite() || !position_m[f - 1].allFinite()) continue;
    ++steps.count;
    steps.zero += position_m[f] == position_m[f - 1];
    lengths_m.push_back((position_m[f] - position_m[f - 1]).norm());
  }
  if (!lengths_m.empty()) steps.median_m = upper_median(lengths_m);
  return steps;
}

class HeldPositions {
 public:
  HeldPositions(std::span<const MocapTime> time, const std::vector<Positions>& position_m)
      : time_(time), position_m_(position_m) {
    for (const Positions& positions : position_m) steps_.push_back(steps_of(positions));
  }

  // The stretches [first, end) of an asset's frames in which it is held.
  std::vector<std::pair<std::size_t, std::size_t>> of(std::size_t asset) const {
    const Positions& own = position_m_[asset];
    std::vector<std::pair<std::size_t, std::size_t>> held;
    for (std::size_t first = 0, end = 0; first < own.size(); first = end) {
      end = first + 1;
      if (!own[first].allFinite()) continue;
      while (end < own.size() && own[end] == own[first]) ++end;
      if (end - first >= kMinFrames && time_[end - 1] - time_[first] >= kMinTime &&
          is_held(asset, first, end))
        held.emplace_back(first, end);
    }
    return held;
  }

 private:
  static constexpr std::size_t kMinFrames = 3;
  static constexpr Duration kMinTime{199'000'000};  // 0.2 s, less what times are rounded by

  bool is_held(std::size_t asset, std::size_t first, std::size_t end) const {
    constexpr double kMinMoving = 1.0 / 3.0, kMaxZero = 0.02, kMinJump_m = 0.01, kMinSteps = 5.0;
    std::int64_t known = 0, moving = 0, steps = 0, zero = 0;
    for (std::size_t other = 0; other < position_m_.size(); ++other) {
      if (other == asset || position_m_[other].empty()) continue;
      const auto [is_known, is_moving] = in_stretch(position_m_[other], first, end);
      known += is_known;
      moving += is_moving;
      steps += steps_[other].count;
      zero += steps_[other].zero;
    }
    if (known == 0) {  // alone: its own steps tell whether there is noise
      steps = steps_[asset].count - static_cast<std::int64_t>(end - first - 1);
      zero = steps_[asset].zero - static_cast<std::int64_t>(end - first - 1);
      if (steps < kMinAlone) return false;
    } else if (static_cast<double>(moving) < kMinMoving * static_cast<double>(known)) {
      return false;
    }
    if (static_cast<double>(zero) < kMaxZero * static_cast<double>(steps)) return true;
    const Positions& own = position_m_[asset];
    if (end == own.size() || !own[end].allFinite()) return false;
    const double jump_m = (own[end] - own[first]).norm();
    return jump_m > kMinJump_m && jump_m > kMinSteps * steps_[asset].median_m;
  }

  // Whether another asset is known in most of these frames, and whether it then changes in most of its steps.
  static std::pair<bool, bool> in_stretch(const Positions& other, std::size_t first, std::size_t end) {
    std::size_t known = 0, changes = 0;
    for (std::size_t f = first; f < end; ++f) {
      if (!other[f].allFinite()) continue;
      changes += f > first && other[f - 1].allFinite() && other[f] != other[f - 1];
      ++known;
    }
    return {2 * known > end - first, 2 * known > end - first && 2 * changes >= known - 1};
  }

  static constexpr std::int64_t kMinAlone = 30;  // steps
  std::span<const MocapTime> time_;
  const std::vector<Positions>& position_m_;
  std::vector<Steps> steps_;
};

}  // namespace

std::vector<MissingCounts> remove_missing(std::span<const MocapTime> time,
                                          std::vector<Positions>& position_m) {
  std::vector<MissingCounts> counts(position_m.size());
  for (std::size_t a = 0; a < position_m.size(); ++a) remove_marked(position_m[a], counts[a]);
  remove_fill_values(position_m, counts);
  remove_equal_numbers(position_m, counts);
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> held;
  const HeldPositions found(time, position_m);
  for (std::size_t a = 0; a < position_m.size(); ++a) held.push_back(found.of(a));
  for (std::size_t a = 0; a < position_m.size(); ++a)
    for (const auto& [first, end] : held[a]) {
      std::fill(position_m[a].begin() + static_cast<std::ptrdiff_t>(first + 1),
                position_m[a].begin() + static_cast<std::ptrdiff_t>(end), kNone);
      counts[a].held += static_cast<std::int64_t>(end - first - 1);
    }
  return counts;
}

}  // namespace trilat
