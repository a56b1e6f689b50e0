// SPDX-License-Identifier: MIT
#include "pipeline/stream_fit/stream_change.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "evaluators/alignment/alignment.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {
namespace {

// Definitions of a joint differ by up to so much; the mean difference of a point is taken off its error.
constexpr double kMaxOffset_m = 0.10;
constexpr double kBlock_s = 2.5, kMinBlock_s = 0.4;
constexpr double kWantedBlocks = 12.0, kMaxBlocks = 400.0;
constexpr double kInstantsOfBlock = 10.0;
constexpr double kMinPairsOfBlock = 6.0;

Eigen::Matrix3d best_axes(const Eigen::Matrix3d& products, bool mirrored) {
  double best = -HUGE_VAL;
  Eigen::Matrix3d found = Eigen::Matrix3d::Identity();
  for (const Eigen::Matrix3d& axes : signed_axes(mirrored)) {
    if (!mirrored && axes.isIdentity()) continue;
    if (const double agreement = (axes * products).trace(); agreement > best) {
      best = agreement;
      found = axes;
    }
  }
  return found;
}

std::size_t block_at(const StreamPair& pair, const TimeBlocks& blocks, std::size_t instant) {
  const double since_s = static_cast<double>(instant) / pair.reference.rate_hz;
  return std::min(blocks.count - 1, static_cast<std::size_t>(since_s / blocks.length_s));
}

Eigen::Vector3d limited(const Eigen::Vector3d& offset_m) {
  const double length_m = offset_m.norm();
  return length_m > kMaxOffset_m ? Eigen::Vector3d(kMaxOffset_m / length_m * offset_m) : offset_m;
}

struct Pair {
  std::size_t point, block;
  Eigen::Vector3d reference_m, subject_m;
};

std::vector<Pair> pairs_of_change(const StreamPair& pair, const TimeBlocks& blocks,
                                  const StreamChange& change) {
  std::vector<Pair> pairs;
  ChangedPairs changed(pair, change);
  for (std::size_t i = 0; i < pair.reference.instants(); i += blocks.step)
    changed.visit(i, [&](std::size_t j, const Eigen::Vector3d& reference, const Eigen::Vector3d& subject) {
      pairs.push_back({j, block_at(pair, blocks, i), reference, subject});
    });
  return pairs;
}

}  // namespace

const std::vector<Eigen::Matrix3d>& signed_axes(bool mirrored) {
  static const std::array<std::vector<Eigen::Matrix3d>, 2> all = [] {
    std::array<std::vector<Eigen::Matrix3d>, 2> lists;
    std::array<int, 3> order{0, 1, 2};
    do {
      for (int signs = 0; signs < 8; ++signs) {
        Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
        for (int row = 0; row < 3; ++row)
          axes(row, order.at(static_cast<std::size_t>(row))) = (signs >> row & 1) != 0 ? -1.0 : 1.0;
        lists.at(axes.determinant() < 0.0 ? 1 : 0).push_back(axes);
      }
    } while (std::ranges::next_permutation(order).found);
    return lists;
  }();
  return all.at(mirrored ? 1 : 0);
}

void undo_sizes(const std::vector<SizeChange>& sizes, double subject_s, std::span<Eigen::Vector3d> points_m) {
  for (const SizeChange& size : sizes) {
    if (!size.holds(subject_s)) continue;
    for (std::size_t j = 0; j < points_m.size(); ++j)
      if (size.axis)
        points_m[j][*size.axis] /= size.factor;
      else if (!size.point || *size.point == j)
        points_m[j] /= size.factor;
  }
}

unsigned causes_of(const StreamChange& change) {
  unsigned causes = 0;
  for (const SizeChange& size : change.sizes)
    causes |= size.point  ? kPointSizeCause
              : size.axis ? kAxisSizeCause
              : size.at_s ? kLaterSizeCause
                          : kSizeCause;
  if (change.has_start) causes |= kStartCause;
  if (change.has_stretch) causes |= kRateCause;
  for (std::size_t j = 0; j < change.order.size(); ++j)
    if (change.order[j] != j) causes |= kSidesCause;
  if (change.frame != FrameChange::none && change.frame != FrameChange::axes) causes |= kShiftCause;
  if (change.frame >= FrameChange::axes) causes |= kTurnCause;
  if (change.mirrored) causes |= kMirrorCause;
  if (change.root) causes |= kRootCause;
  return causes;
}

int parameters_of(const StreamChange& change) {
  constexpr std::array kOfFrame{0, 3, 1, 4, 6};
  int count = kOfFrame.at(static_cast<std::size_t>(change.frame));
  for (const SizeChange& size : change.sizes) count += 1 + (size.at_s ? 1 : 0) + (size.is_unit ? 0 : 1);
  if (change.has_start) count += 2;
  if (change.has_stretch) count += 2;
  if ((causes_of(change) & kSidesCause) != 0) ++count;
  if (change.mirrored) ++count;
  if (change.root) count += change.root->turns ? 4 : 3;
  return count;
}

FrameFit fit_frame(const FrameSums& sums, FrameChange kind, bool mirrored) {
  FrameFit fit;
  if (sums.pairs == 0.0) return fit;
  const bool is_shifted = kind != FrameChange::none && kind != FrameChange::axes;
  const Eigen::Vector3d reference_m = sums.reference_m / sums.pairs,
                        subject_m = sums.of_subject_m / sums.pairs;
  Eigen::Matrix3d products = sums.products_m2;
  double squares_m2 = sums.reference_m2 + sums.subject_m2;
  if (is_shifted) {
    products -= sums.pairs * subject_m * reference_m.transpose();
    squares_m2 -= sums.pairs * (reference_m.squaredNorm() + subject_m.squaredNorm());
  }
  if (kind == FrameChange::turned && products.allFinite()) {
    const RotationFit turn = fit_rotation(products.transpose());
    fit.rotation = mirrored ? turn.mirrored_b_from_a : turn.b_from_a;
  }
  if (kind >= FrameChange::axes && kind != FrameChange::turned) fit.rotation = best_axes(products, mirrored);
  if (is_shifted) fit.shift_m = reference_m - fit.rotation * subject_m;
  fit.squares_m2 = std::max(0.0, squares_m2 - 2.0 * (fit.rotation * products).trace());
  return fit;
}

ChangedPairs::ChangedPairs(const StreamPair& pair, const StreamChange& change)
    : pair_(pair), change_(change), order_(change.order), points_m_(pair.subject.points) {
  if (!order_.empty()) return;
  order_.resize(points_m_.size());
  std::iota(order_.begin(), order_.end(), 0);
}

void ChangedPairs::look(std::size_t instant) {
  const double first_s = pair_.subject.first_s;
  const double when_s =
      first_s + (pair_.reference.time_s(instant) - first_s - change_.start_s) / change_.stretch;
  pair_.subject.at_time(when_s, points_m_);
  undo_sizes(change_.sizes, when_s, points_m_);
  if (!change_.root) return;
  const Eigen::Vector3d one_m = pair_.reference.at(instant, change_.root->one),
                        other_m = pair_.reference.at(instant, change_.root->other), along_m = other_m - one_m;
  root_m_ = 0.5 * (one_m + other_m);
  if (change_.root->keeps_height) root_m_.y() = 0.0;
  if (change_.root->turns)
    body_from_world_ =
        Eigen::AngleAxisd(std::atan2(along_m.z(), along_m.x()), Eigen::Vector3d::UnitY()).toRotationMatrix();
}

TimeBlocks blocks_of(const StreamPair& pair) {
  const double duration_s = pair.reference.duration_s();
  TimeBlocks blocks;
  blocks.length_s =
      std::clamp(std::min(duration_s, pair.subject.duration_s()) / kWantedBlocks, kMinBlock_s, kBlock_s);
  blocks.length_s = std::max(blocks.length_s, duration_s / kMaxBlocks);
  blocks.count = std::max<std::size_t>(1, static_cast<std::size_t>(duration_s / blocks.length_s + 1e-9));
  blocks.length_s = std::max(duration_s, 1e-9) / static_cast<double>(blocks.count) * (1.0 + 1e-12);
  blocks.step = std::max<std::size_t>(
      1, static_cast<std::size_t>(blocks.length_s * pair.reference.rate_hz / kInstantsOfBlock));
  return blocks;
}

double mean_of_known(const std::vector<double>& values) {
  double sum = 0.0, count = 0.0;
  for (const double value : values)
    if (std::isfinite(value)) {
      sum += value;
      count += 1.0;
    }
  return count > 0.0 ? sum / count : kNaN;
}

ChangeErrors errors_of_change(const StreamPair& pair, const TimeBlocks& blocks, const StreamChange& change) {
  const std::vector<Pair> pairs = pairs_of_change(pair, blocks, change);
  const std::size_t points = pair.reference.points;
  std::array<FrameSums, 2> sums;
  for (const Pair& p : pairs) sums.at(p.block % 2).add(p.reference_m, p.subject_m);
  std::array<FrameFit, 2> fits;
  std::array<std::vector<Eigen::Vector3d>, 2> offset_m;
  for (std::size_t half = 0; half < 2; ++half) {
    fits.at(half) = fit_frame(sums.at(half), change.frame, change.mirrored);
    offset_m.at(half).assign(points, Eigen::Vector3d::Zero());
  }
  std::vector<std::array<double, 2>> counts(points, {0.0, 0.0});
  for (const Pair& p : pairs) {
    const FrameFit& fit = fits.at(p.block % 2);
    offset_m.at(p.block % 2)[p.point] += p.reference_m - fit.rotation * p.subject_m - fit.shift_m;
    counts[p.point].at(p.block % 2) += 1.0;
  }
  for (std::size_t half = 0; half < 2; ++half)
    for (std::size_t j = 0; j < points; ++j)
      offset_m.at(half)[j] = limited(offset_m.at(half)[j] / std::max(1.0, counts[j].at(half)));
  ChangeErrors errors{std::vector<double>(blocks.count, 0.0), std::vector<double>(blocks.count, 0.0),
                      std::vector<double>(blocks.count, 0.0), std::vector<double>(points, 0.0)};
  for (const Pair& p : pairs) {
    const std::size_t other = 1 - p.block % 2;
    const FrameFit& fit = fits.at(other);
    const Eigen::Vector3d left_m = p.reference_m - fit.rotation * p.subject_m - fit.shift_m;
    errors.judged_m[p.block] += (left_m - offset_m.at(other)[p.point]).norm();
    errors.plain_m[p.block] += left_m.norm();
    errors.pairs[p.block] += 1.0;
    errors.of_point_m[p.point] += left_m.norm();
  }
  for (std::size_t b = 0; b < blocks.count; ++b) {
    const bool is_known = errors.pairs[b] >= kMinPairsOfBlock && sums[0].pairs > 0.0 && sums[1].pairs > 0.0;
    errors.judged_m[b] = is_known ? errors.judged_m[b] / errors.pairs[b] : kNaN;
    errors.plain_m[b] = is_known ? errors.plain_m[b] / errors.pairs[b] : kNaN;
  }
  for (std::size_t j = 0; j < points; ++j)
    errors.of_point_m[j] =
        counts[j][0] + counts[j][1] > 0.0 ? errors.of_point_m[j] / (counts[j][0] + counts[j][1]) : kNaN;
  return errors;
}

StreamChange fitted(const StreamPair& pair, const TimeBlocks& blocks, StreamChange change) {
  FrameSums sums;
  for (const Pair& p : pairs_of_change(pair, blocks, change)) sums.add(p.reference_m, p.subject_m);
  const FrameFit fit = fit_frame(sums, change.frame, change.mirrored);
  change.rotation = fit.rotation;
  change.shift_m = fit.shift_m;
  return change;
}

}  // namespace trilat
