// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include "pipeline/stream_fit/sensor_fit.h"
#include "pipeline/stream_fit/stream_change.h"

namespace trilat {
namespace {

constexpr double kMovement_s = 0.1;  // to both sides
constexpr double kMaxLag_s = 1.0;
constexpr double kAgreeingShare = 0.7;     // of the movements may be left: else they are the trackers' noise
constexpr double kLagTimes = 1.03;         // so much more is left without the lag
constexpr double kMinLagDuration_s = 6.0;  // in less a few steps agree at several lags
constexpr std::size_t kMinLagBlocks = 6, kMaxLagLooks = 3000;
constexpr std::size_t kMinBlocksBesidePush = 3, kMaxPushes = 30;

// How far points move about each instant.
PointStream movements_of(const PointStream& stream) {
  const auto reach =
      static_cast<std::size_t>(std::max(1LL, std::llround(kMovement_s * stream.rate_hz))) * stream.points;
  PointStream moves = stream;
  for (std::size_t k = 0; k < moves.at_m.size(); ++k) {
    moves.at_m[k].setConstant(kNaN);
    if (k >= reach && k + reach < moves.at_m.size())
      moves.at_m[k] = stream.at_m[k + reach] - stream.at_m[k - reach];
  }
  return moves;
}

double mean_length_m(const PointStream& moves) {
  double sum_m = 0.0, count = 0.0;
  for (const Eigen::Vector3d& moved_m : moves.at_m)
    if (moved_m.allFinite()) {
      sum_m += moved_m.norm();
      count += 1.0;
    }
  return sum_m / count;
}

ViewPush push_at(const PointStream& view, const PointStream& others, double at_s) {
  ViewPush push{at_s, 0.0, 0.0, 0.0};
  std::array<StreamChange, 2> poses;
  double blocks_known = 0.0;
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const bool is_after : {false, true}) {
    PointStream part = view;
    for (std::size_t k = 0; k < part.at_m.size(); ++k)
      if ((part.time_s(k / part.points) >= at_s) != is_after) part.at_m[k].setConstant(kNaN);
    const StreamPair pair{others, part};
    const TimeBlocks blocks = blocks_of(pair);
    const StreamChange turned{.frame = FrameChange::turned};
    const ChangeErrors errors = errors_of_change(pair, blocks, turned);
    poses.at(is_after ? 1 : 0) = fitted(pair, blocks, turned);
    for (std::size_t b = 0; b < blocks.count; ++b)
      if (std::isfinite(errors.judged_m[b])) {
        push.judged_m += errors.judged_m[b];
        push.plain_m += errors.plain_m[b];
        blocks_known += 1.0;
      }
    for (const Eigen::Vector3d& at_m : part.at_m)
      if (at_m.allFinite()) {
        middle_m += at_m;
        count += 1.0;
      }
  }
  push.judged_m /= blocks_known;
  push.plain_m /= blocks_known;
  middle_m /= count;
  push.moved_m =
      (poses[1].rotation * middle_m + poses[1].shift_m - poses[0].rotation * middle_m - poses[0].shift_m)
          .norm();
  return push;
}

}  // namespace

ViewLag lag_of(const PointStream& view, const PointStream& others) {
  const PointStream moves = movements_of(view), of_others = movements_of(others);
  const StreamPair pair{of_others, moves};
  TimeBlocks blocks = blocks_of(pair);
  if (blocks.count < kMinLagBlocks || of_others.duration_s() < kMinLagDuration_s) return {};
  blocks.step = 1 + of_others.instants() / kMaxLagLooks;
  const auto reach = static_cast<std::ptrdiff_t>(std::floor(kMaxLag_s * view.rate_hz));
  const double baseline_m = mean_length_m(of_others);
  std::vector<std::vector<double>> left;  // by lag and block
  for (std::ptrdiff_t lag = -reach; lag <= reach; ++lag) {
    const StreamChange late{.start_s = -static_cast<double>(lag) / view.rate_hz, .has_start = true};
    left.push_back(errors_of_change(pair, blocks, late).judged_m);
  }
  const auto best_without = [&](std::size_t without) {
    std::vector<double> mean;
    for (const std::vector<double>& of_lag : left) {
      std::vector<double> kept = of_lag;
      if (without < kept.size()) kept[without] = kNaN;
      mean.push_back(mean_of_known(kept));
    }
    const auto k = static_cast<std::size_t>(std::ranges::min_element(mean) - mean.begin());
    if (k == 0 || k + 1 == mean.size() || mean[static_cast<std::size_t>(reach)] < kLagTimes * mean[k])
      return kNaN;
    if (mean[k] > kAgreeingShare * baseline_m) return kNaN;
    const double below = mean[k - 1], above = mean[k + 1];
    const double between = 0.5 * (below - above) / (below - 2.0 * mean[k] + above);
    return (static_cast<double>(k) - static_cast<double>(reach) + between) / view.rate_hz;
  };
  ViewLag lag{best_without(blocks.count), 0.0};
  for (std::size_t b = 0; b < blocks.count; ++b) lag.sigma_s += std::pow(best_without(b) - lag.lag_s, 2);
  const auto n = static_cast<double>(blocks.count);
  lag.sigma_s = std::sqrt((n - 1.0) / n * lag.sigma_s);
  return lag;
}

ViewPush best_push(const PointStream& view, const PointStream& others) {
  const TimeBlocks blocks = blocks_of({others, view});
  const std::size_t step = 1 + blocks.count / kMaxPushes;
  ViewPush best;
  for (std::size_t b = kMinBlocksBesidePush; b + kMinBlocksBesidePush <= blocks.count; b += step)
    if (const ViewPush push = push_at(view, others, view.first_s + static_cast<double>(b) * blocks.length_s);
        push.judged_m < best.judged_m)
      best = push;
  return best;
}

}  // namespace trilat
