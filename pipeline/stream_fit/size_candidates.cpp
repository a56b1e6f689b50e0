// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include "datasets/base/median.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/stream_fit/stream_search.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxLengthLooks = 300;  // instants
constexpr double kMinLength_m = 0.05;         // shorter distances give no ratio
constexpr double kMinTriedScale = 0.03;       // below, no scale is tried
constexpr double kNearUnit = 0.12;            // of a logarithm
constexpr double kNearUnitOfAxis = 0.4;  // the same; markers lie on another side of a joint than trackers
constexpr double kPart_s = 0.25;         // of time, for a unit that changes
constexpr std::size_t kMaxParts = 400;
constexpr double kMinJump = 0.5;       // of the logarithm of the ratio
constexpr double kMinPointJump = 0.7;  // the same for one point
constexpr double kMinAxisJump = 2.0;   // of one axis; a person who stands is a few centimetres deep
constexpr double kMinMovement_m = 0.03;
constexpr double kStaysWithin = 0.15;  // of the reference's movement, for a root
constexpr double kFlat_m = 0.002, kDeep_m = 0.05;
// Factors between the units of files: mm, cm, dm, m, inches and feet.
constexpr std::array kUnits{1000.0, 100.0, 10.0,     0.1,  0.01,     0.001, 39.3701,   0.0254, 3.28084,
                            0.3048, 25.4,  1 / 25.4, 2.54, 1 / 2.54, 304.8, 1 / 304.8, 12.0,   1 / 12.0};

// Unit of a ratio, or the ratio itself.
SizeChange size_of(double ratio, double near = kNearUnit) {
  SizeChange size{.factor = ratio};
  for (const double unit : kUnits)
    if (std::abs(std::log(ratio / unit)) < near) {
      if (size.is_unit && std::abs(std::log(ratio / unit)) > std::abs(std::log(ratio / size.factor)))
        continue;
      size.factor = unit;
      size.is_unit = true;
    }
  return size;
}

double median_or_nan(std::vector<double> values) { return values.empty() ? kNaN : median(std::move(values)); }

// Median distance between two points over some instants.
double length_m(const PointStream& stream, std::size_t one, std::size_t other, std::size_t first,
                std::size_t end) {
  std::vector<double> lengths_m;
  const std::size_t step = std::max<std::size_t>(1, (end - first) / kMaxLengthLooks);
  for (std::size_t i = first; i < end; i += step)
    if (const double m = (stream.at(i, one) - stream.at(i, other)).norm(); std::isfinite(m))
      lengths_m.push_back(m);
  return median_or_nan(std::move(lengths_m));
}

// Lengths of the reference that tell a ratio.
struct Length {
  std::size_t one, other;
  double reference_m;
};

std::vector<Length> lengths_of(const PointStream& reference) {
  std::vector<Length> lengths;
  for (std::size_t j = 0; j < reference.points; ++j)
    for (std::size_t k = j + 1; k < reference.points; ++k)
      if (const double m = length_m(reference, j, k, 0, reference.instants()); m > kMinLength_m)
        lengths.push_back({j, k, m});
  return lengths;
}

double ratio_of(const PointStream& subject, const std::vector<Length>& lengths, std::size_t first,
                std::size_t end) {
  std::vector<double> ratios;
  for (const Length& length : lengths)
    if (const double m = length_m(subject, length.one, length.other, first, end); std::isfinite(m))
      ratios.push_back(m / length.reference_m);
  return median_or_nan(std::move(ratios));
}

// Ratios before and after the instant at which they change most, if they do.
struct RatioJump {
  double before, after, at_s;
};

std::optional<RatioJump> jump_of(const PointStream& subject, const std::vector<Length>& lengths) {
  const std::size_t part = std::max(
      {std::size_t{1}, static_cast<std::size_t>(kPart_s * subject.rate_hz), subject.instants() / kMaxParts});
  std::vector<double> logs;
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i + part <= subject.instants(); i += part)
    if (const double ratio = ratio_of(subject, lengths, i, i + part); ratio > 0.0) {
      logs.push_back(std::log(ratio));
      first.push_back(i);
    }
  constexpr std::size_t kMinParts = 4;
  std::optional<RatioJump> best;
  double least = HUGE_VAL;
  for (std::size_t k = kMinParts; k + kMinParts <= logs.size(); ++k) {
    const double before = median({logs.begin(), logs.begin() + static_cast<std::ptrdiff_t>(k)});
    const double after = median({logs.begin() + static_cast<std::ptrdiff_t>(k), logs.end()});
    double off = 0.0;
    for (std::size_t n = 0; n < logs.size(); ++n) off += std::abs(logs[n] - (n < k ? before : after));
    if (std::abs(after - before) < kMinJump || off >= least) continue;
    least = off;
    best = {std::exp(before), std::exp(after), subject.time_s(first[k])};
  }
  if (!best) return best;
  // the parts of a quarter of a second tell the second; the instant is the first that is nearer to the later
  // ratio
  const double between = std::sqrt(best->before * best->after);
  const auto about = static_cast<std::size_t>((best->at_s - subject.first_s) * subject.rate_hz + 0.5);
  for (std::size_t i = about > 2 * part ? about - 2 * part : 0;
       i < std::min(subject.instants(), about + 2 * part); ++i)
    if (const double ratio = ratio_of(subject, lengths, i, i + 1);
        std::isfinite(ratio) && (ratio > between) == (best->after > best->before)) {
      best->at_s = subject.time_s(i) - 0.5 / subject.rate_hz;
      break;
    }
  return best;
}

// Root mean square about the mean, and the mean.
struct PointSpread {
  double moves_m;
  Eigen::Vector3d mean_m;
};

PointSpread spread_of(const PointStream& stream, std::size_t one, std::size_t other) {
  double count = 0.0, squares_m2 = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < stream.instants(); ++i) {
    const Eigen::Vector3d at_m = 0.5 * (stream.at(i, one) + stream.at(i, other));
    if (!at_m.allFinite()) continue;
    count += 1.0;
    sum += at_m;
    squares_m2 += at_m.squaredNorm();
  }
  if (count < 3.0) return {kNaN, Eigen::Vector3d::Constant(kNaN)};
  return {std::sqrt(std::max(0.0, squares_m2 / count - (sum / count).squaredNorm())), sum / count};
}

// A point in another unit than the rest.
void add_points(const StreamPair& pair, const std::vector<SizeChange>& of_all,
                std::vector<std::vector<SizeChange>>& candidates) {
  const double all = of_all.empty() ? 1.0 : of_all.front().factor;
  for (std::size_t j = 0; j < pair.subject.points; ++j) {
    const PointSpread reference = spread_of(pair.reference, j, j), subject = spread_of(pair.subject, j, j);
    const auto add = [&](double ratio) {
      if (!(ratio > 0.0) || std::abs(std::log(ratio)) < kMinPointJump) return;
      SizeChange size = size_of(ratio);
      if (!size.is_unit) return;
      size.point = j;
      candidates.push_back(of_all);
      candidates.back().push_back(size);
    };
    add(subject.mean_m.norm() / reference.mean_m.norm() / all);
    if (reference.moves_m > kMinMovement_m) add(subject.moves_m / reference.moves_m / all);
  }
}

// Mean distance of all points along an axis from where they are in the mean.
double extent_m(const PointStream& stream, int axis) {
  double count = 0.0, sum_m = 0.0, off_m = 0.0;
  const auto each = [&](const auto& visit) {
    for (const Eigen::Vector3d& at_m : stream.at_m)
      if (at_m.allFinite()) visit(at_m[axis]);
  };
  each([&](double m) { sum_m += m, count += 1.0; });
  each([&](double m) { off_m += std::abs(m - sum_m / count); });
  return off_m / count;
}

// Median distance of all points along an axis from their median: a point in another unit does not matter.
double half_width_m(const PointStream& stream, int axis) {
  constexpr std::size_t kMaxPositions = 20'000;
  std::vector<double> along_m;
  const std::size_t step = 1 + stream.at_m.size() / kMaxPositions;
  for (std::size_t k = 0; k < stream.at_m.size(); k += step)
    if (stream.at_m[k].allFinite()) along_m.push_back(stream.at_m[k][axis]);
  if (along_m.empty()) return kNaN;
  const double middle_m = median(along_m);
  for (double& m : along_m) m = std::abs(m - middle_m);
  return median(std::move(along_m));
}

// One axis on a scale of its own, as a depth that was guessed has it. The others agree, where they are wide.
void add_axis_scale(const StreamPair& pair, std::vector<std::vector<SizeChange>>& candidates) {
  constexpr double kAgree = 0.1, kMinScale = 0.1;  // of a logarithm
  constexpr double kMinWidth_m = 0.15;             // a person who stands is a few centimetres deep
  constexpr double kMinPath_m = 0.1;
  bool moves = false;  // else an axis and the whole are not told apart
  for (std::size_t j = 0; j < pair.reference.points; ++j)
    moves |= spread_of(pair.reference, j, j).moves_m > kMinPath_m;
  if (!moves) return;
  std::array<std::optional<double>, 3> logs;
  for (int axis = 0; axis < 3; ++axis)
    if (const double reference_m = half_width_m(pair.reference, axis); reference_m > kMinWidth_m)
      logs.at(static_cast<std::size_t>(axis)) = std::log(half_width_m(pair.subject, axis) / reference_m);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::optional<double> one = logs.at((axis + 1) % 3), other = logs.at((axis + 2) % 3);
    if (!logs.at(axis) || (one && other && std::abs(*one - *other) > kAgree)) continue;
    const double scale =
        *logs.at(axis) - 0.5 * (one.value_or(other.value_or(0.0)) + other.value_or(one.value_or(0.0)));
    if (std::abs(scale) > kMinScale)
      candidates.push_back({{.factor = std::exp(scale), .axis = static_cast<int>(axis)}});
  }
}

// One or two axes in another unit than the rest.
void add_axes(const StreamPair& pair, std::vector<std::vector<SizeChange>>& candidates) {
  std::vector<SizeChange> sizes;
  for (int axis = 0; axis < 3; ++axis) {
    const double ratio = extent_m(pair.subject, axis) / extent_m(pair.reference, axis);
    if (!(std::abs(std::log(ratio)) > kMinAxisJump)) continue;
    SizeChange size = size_of(ratio, kNearUnitOfAxis);
    if (!size.is_unit) return;
    size.axis = axis;
    sizes.push_back(size);
  }
  if (sizes.size() == 1 || sizes.size() == 2) candidates.push_back(std::move(sizes));
}

}  // namespace

std::vector<std::vector<SizeChange>> size_candidates(const StreamPair& pair) {
  std::vector<std::vector<SizeChange>> candidates(1);
  add_axes(pair, candidates);
  if (candidates.size() > 1) return candidates;  // with an axis that large, lengths tell nothing
  const std::vector<Length> lengths = lengths_of(pair.reference);
  const auto add_ratio = [](double ratio, std::vector<SizeChange>& sizes) {
    const SizeChange size = size_of(ratio);
    if (size.is_unit || std::abs(std::log(ratio)) > std::log1p(kMinTriedScale)) sizes.push_back(size);
  };
  if (const auto jump = jump_of(pair.subject, lengths)) {
    // the part that is nearer to the reference's size is the sound one
    const bool until = std::abs(std::log(jump->before)) > std::abs(std::log(jump->after));
    const double sound = until ? jump->after : jump->before, other = until ? jump->before : jump->after;
    std::vector<SizeChange> sizes;
    add_ratio(sound, sizes);
    SizeChange part = size_of(other / sound);
    part.at_s = jump->at_s;
    part.until = until;
    sizes.push_back(part);
    candidates.push_back(std::move(sizes));
    return candidates;
  }
  std::vector<SizeChange> of_all;
  const double ratio = ratio_of(pair.subject, lengths, 0, pair.subject.instants());
  if (ratio > 0.0) {
    add_ratio(ratio, of_all);
  } else if (pair.subject.points == 1) {
    const PointSpread reference = spread_of(pair.reference, 0, 0), subject = spread_of(pair.subject, 0, 0);
    if (reference.moves_m > kMinMovement_m && subject.moves_m > 0.0)
      add_ratio(subject.moves_m / reference.moves_m, of_all);
  }
  if (!of_all.empty()) candidates.push_back(of_all);
  const std::size_t of_the_whole = candidates.size();
  if (pair.subject.points > 1) add_points(pair, of_all, candidates);
  if (candidates.size() == of_the_whole) add_axis_scale(pair, candidates);
  constexpr std::size_t kMax = 6;
  candidates.resize(std::min(candidates.size(), kMax));
  return candidates;
}

namespace {

// How constant the direction from one point to another is about y, of 1; NaN where it is not known.
double steadiness(const PointStream& stream, std::size_t one, std::size_t other) {
  double count = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < stream.instants(); ++i) {
    const Eigen::Vector3d along_m = stream.at(i, other) - stream.at(i, one);
    const Eigen::Vector2d level_m(along_m.x(), along_m.z());
    if (!level_m.allFinite() || level_m.norm() == 0.0) continue;
    sum += level_m.normalized();
    count += 1.0;
  }
  return count < 3.0 ? kNaN : sum.norm() / count;
}

BodyRoot root_about(const StreamPair& pair, std::size_t one, std::size_t other, const PointSpread& reference,
                    const PointSpread& subject) {
  constexpr double kSameHeight_m = 0.2, kSteady = 0.98, kTurning = 0.9;
  const double height_m = reference.mean_m.y();
  return {.one = one,
          .other = other,
          .keeps_height =
              std::abs(height_m) > kSameHeight_m && std::abs(subject.mean_m.y() - height_m) < kSameHeight_m,
          .turns = steadiness(pair.subject, one, other) > kSteady &&
                   steadiness(pair.reference, one, other) < kTurning};
}

}  // namespace

std::vector<BodyRoot> root_candidates(const StreamPair& pair, const std::vector<std::size_t>& mirrored) {
  std::vector<std::pair<double, BodyRoot>> found;  // what of the reference's movement the subject has
  for (std::size_t j = 0; j < mirrored.size(); ++j) {
    for (const std::size_t other : {j, mirrored[j]}) {
      if (other < j || (other == j && !found.empty() && found.back().second.one == j)) continue;
      const PointSpread reference = spread_of(pair.reference, j, other);
      const PointSpread subject = spread_of(pair.subject, j, other);
      if (!(reference.moves_m > kMinMovement_m)) continue;
      const double share = std::isnan(subject.moves_m) ? 0.0 : subject.moves_m / reference.moves_m;
      if (share < kStaysWithin) found.emplace_back(share, root_about(pair, j, other, reference, subject));
    }
  }
  std::ranges::stable_sort(found, {}, &std::pair<double, BodyRoot>::first);
  constexpr std::size_t kMax = 4;
  std::vector<BodyRoot> roots;
  for (const auto& [share, root] : std::span(found).first(std::min(found.size(), kMax)))
    roots.push_back(root);
  return roots;
}

std::optional<int> flat_axis(const StreamPair& pair) {
  Eigen::Array3d least = Eigen::Array3d::Constant(HUGE_VAL), most = -least;
  Eigen::Array3d least_reference = least, most_reference = most;
  for (const Eigen::Vector3d& at_m : pair.subject.at_m)
    if (at_m.allFinite()) {
      least = least.min(at_m.array());
      most = most.max(at_m.array());
    }
  for (const Eigen::Vector3d& at_m : pair.reference.at_m)
    if (at_m.allFinite()) {
      least_reference = least_reference.min(at_m.array());
      most_reference = most_reference.max(at_m.array());
    }
  if (!((most_reference - least_reference).minCoeff() > kDeep_m)) return std::nullopt;
  std::optional<int> flat;
  for (int axis = 0; axis < 3; ++axis)
    if (most[axis] - least[axis] < kFlat_m) {
      if (flat) return std::nullopt;
      flat = axis;
    }
  return flat;
}

}  // namespace trilat
