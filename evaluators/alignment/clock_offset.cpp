// SPDX-License-Identifier: MIT
#include "evaluators/alignment/clock_offset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "datasets/base/error.h"
#include "datasets/base/median.h"
#include "evaluators/alignment/alignment.h"
#include "evaluators/metrics/statistics.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr double kCoarse_s = 1.0 / 30.0;
constexpr double kNearHighest = 0.8;

// One joint's truth on a regular grid: speed, position, and position less what is slow; NaN where not
// covered. Single precision: a tenth of a micrometre at a metre.
struct TruthGrid {
  double start_s = 0.0, step_s = 0.0;
  std::vector<float> speed_m_s;
  std::vector<Eigen::Vector3f> position_m, high_pass_m;

  double speed_at(double time_s) const {
    const auto [k, share] = place_of(time_s, speed_m_s.size());
    if (!(share >= 0.0)) return kNaN;
    const auto before = static_cast<double>(speed_m_s[k]), after = static_cast<double>(speed_m_s[k + 1]);
    return before + share * (after - before);
  }
  Vector3d position_at(double time_s) const { return at(position_m, time_s); }
  Vector3d quick_at(double time_s) const { return at(high_pass_m, time_s); }
  Vector3d rate_at(double time_s) const {
    return (quick_at(time_s + step_s) - quick_at(time_s - step_s)) / (2.0 * step_s);
  }

 private:
  // Between which two points of the grid; NaN outside.
  std::pair<std::size_t, double> place_of(double time_s, std::size_t size) const {
    const double place = (time_s - start_s) / step_s;
    if (!(place >= 0.0) || place + 1.0 >= static_cast<double>(size)) return {0, kNaN};
    const auto k = static_cast<std::size_t>(place);
    return {k, place - static_cast<double>(k)};
  }
  Vector3d at(const std::vector<Eigen::Vector3f>& values, double time_s) const {
    const auto [k, share] = place_of(time_s, values.size());
    if (!(share >= 0.0)) return Vector3d::Constant(kNaN);
    const Vector3d before = values[k].cast<double>();
    return before + share * (values[k + 1].cast<double>() - before);
  }
};

// One joint's estimate at one time: speed, position, and position less what is slow, in single precision.
struct BandPassedMotion {
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  float speed_m_s = kNone;
  Eigen::Vector3f position_m = Eigen::Vector3f::Constant(kNone),
                  high_pass_m = Eigen::Vector3f::Constant(kNone);
};

BandPassedMotion quick_motion(const PointPath& path, double time_s, const ClockOffsetOptions& options) {
  const auto motion = local_motion(path, time_s, options.smooth_s, options.longest_gap_s);
  if (!motion) return {};
  const auto slow = local_motion(path, time_s, options.slow_s, options.longest_gap_s);
  const Vector3d slow_m = slow ? slow->position_m : Vector3d::Constant(kNaN);
  return {static_cast<float>(motion->velocity_m_s.norm()), motion->position_m.cast<float>(),
          (motion->position_m - slow_m).cast<float>()};
}

TruthGrid grid_of(const PointPath& path, const ClockOffsetOptions& options) {
  TruthGrid grid;
  grid.step_s = 1.0 / options.grid_hz;
  if (path.time_s.empty()) return grid;
  grid.start_s = path.time_s.front();
  const auto count = static_cast<std::size_t>((path.time_s.back() - grid.start_s) * options.grid_hz) + 1;
  grid.speed_m_s.reserve(count);
  grid.position_m.reserve(count);
  grid.high_pass_m.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const BandPassedMotion motion =
        quick_motion(path, grid.start_s + static_cast<double>(k) * grid.step_s, options);
    grid.speed_m_s.push_back(motion.speed_m_s);
    grid.position_m.push_back(motion.position_m);
    grid.high_pass_m.push_back(motion.high_pass_m);
  }
  return grid;
}

// One joint of both streams, ready to be compared.
struct ComparedJoint {
  std::vector<double> time_s;
  std::vector<BandPassedMotion> estimate;
  std::shared_ptr<const TruthGrid> truth;  // parts of a joint share it

  // Samples that must meet a truth at an offset: half of them, or most of what a truth that covers a part of
  // the take can meet.
  double samples_needed() const {
    constexpr double kOfAll = 0.5, kOfCovered = 0.8;
    const auto samples = static_cast<double>(time_s.size());
    if (samples < 2.0) return samples;
    const double known = static_cast<double>(
        std::ranges::count_if(truth->speed_m_s, [](float speed_m_s) { return std::isfinite(speed_m_s); }));
    const double covered = known * truth->step_s * (samples - 1.0) / (time_s.back() - time_s.front());
    return std::min(kOfAll * samples, kOfCovered * covered);
  }
};

struct Correlation {
  double value = kNaN;
  double spread_m_s = 0.0;  // root mean square of the truth's speed about its mean
};

// Correlation of the speeds at one offset.
Correlation correlation(const ComparedJoint& joint, double needed, double offset_s) {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, yy = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < joint.time_s.size(); ++i) {
    const double a = static_cast<double>(joint.estimate[i].speed_m_s),
                 b = joint.truth->speed_at(joint.time_s[i] + offset_s);
    if (!std::isfinite(a) || !std::isfinite(b)) continue;
    n += 1.0;
    x += a;
    y += b;
    xx += a * a;
    yy += b * b;
    xy += a * b;
  }
  // Far from zero the streams overlap less, and a few samples agree by chance.
  if (n < 10.0 || n < needed) return {};
  const double vx = xx - x * x / n, vy = yy - y * y / n;
  return {vx > 0.0 && vy > 0.0 ? (xy - x * y / n) / std::sqrt(vx * vy) : kNaN,
          std::sqrt(std::max(0.0, vy / n))};
}

// The mean correlation of the joints that move, at a step of the grid.
class SpeedCurve {
 public:
  SpeedCurve(const std::vector<ComparedJoint>& joints, const ClockOffsetOptions& options)
      : joints_(joints), options_(options) {
    for (const ComparedJoint& joint : joints) {
      needed_.push_back(joint.samples_needed());
      moving_.push_back(correlation(joint, needed_.back(), 0.0).spread_m_s >= options.least_speed_m_s);
    }
  }
  bool moves() const { return std::ranges::count(moving_, true) > 0; }
  double at(int step) const {
    double sum = 0.0, count = 0.0;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      if (!moving_[j]) continue;
      const Correlation c = correlation(joints_[j], needed_[j], step / options_.grid_hz);
      if (!std::isfinite(c.value)) continue;
      sum += c.value;
      count += 1.0;
    }
    return count > 0.0 ? sum / count : -1.0;
  }

 private:
  const std::vector<ComparedJoint>& joints_;
  const ClockOffsetOptions& options_;
  std::vector<double> needed_;  // samples, by joint
  std::vector<bool> moving_;
};

struct Peak {
  int step = 0;
  double value = -1.0;
  bool at_end = false;  // of the search: what lies behind may be higher
};

// The peaks of the curve, the highest first: coarsely, and those near the highest to the step. Speeds are
// smoothed, so that the curve has nothing narrower than the coarse steps.
std::vector<Peak> peaks_of(const SpeedCurve& curve, int steps, const ClockOffsetOptions& options) {
  const int stride = std::max(1, static_cast<int>(options.grid_hz * kCoarse_s));
  std::vector<Peak> coarse;
  for (int k = -steps; k < steps; k += stride) coarse.push_back({k, curve.at(k)});
  coarse.push_back({steps, curve.at(steps)});
  std::vector<Peak> peaks;
  double highest = -1.0;
  for (std::size_t k = 0; k < coarse.size(); ++k) {
    const bool first = k == 0, last = k + 1 == coarse.size();
    if ((!first && coarse[k].value < coarse[k - 1].value) || (!last && coarse[k].value < coarse[k + 1].value))
      continue;
    peaks.push_back({coarse[k].step, coarse[k].value, first || last});
    highest = std::max(highest, coarse[k].value);
  }
  for (Peak& peak : peaks) {
    if (peak.at_end || peak.value < kNearHighest * highest) continue;
    const int middle = peak.step;
    for (int k = middle - stride; k <= middle + stride; ++k)
      if (const double value = curve.at(k); value > peak.value) peak = {k, value, false};
  }
  std::ranges::stable_sort(peaks, [](const Peak& a, const Peak& b) { return a.value > b.value; });
  return peaks;
}

// Information of a block of time about the offset: the normal equation of one unknown.
struct NormalEquation {
  double information = 0.0, gradient = 0.0;
  void add(const NormalEquation& other) {
    information += other.information;
    gradient += other.gradient;
  }
};
using Blocks = std::map<std::int64_t, NormalEquation>;

using MotionOf = Eigen::Vector3f BandPassedMotion::*;
using TruthAt = Vector3d (TruthGrid::*)(double) const;

// The estimate onto the truth, as both are at an offset.
RigidTransform rotation_at(const std::vector<ComparedJoint>& joints, double offset_s, MotionOf estimate_m,
                           TruthAt truth_at) {
  AlignmentSums sums;
  for (const ComparedJoint& joint : joints)
    for (std::size_t i = 0; i < joint.time_s.size(); ++i) {
      const Vector3d from_m = (joint.estimate[i].*estimate_m).cast<double>(),
                     to_m = ((*joint.truth).*truth_at)(joint.time_s[i] + offset_s);
      if (from_m.allFinite() && to_m.allFinite()) sums.add(from_m, to_m);
    }
  return solve_alignment(sums, AlignmentKind::rigid).truth_from_estimate;
}

// The median distance between the joints at one offset, after turning the estimate if frames are turned.
double median_distance_m(const std::vector<ComparedJoint>& joints, double offset_s, StreamFrames frames) {
  const RigidTransform turn =
      frames == StreamFrames::turned
          ? rotation_at(joints, offset_s, &BandPassedMotion::position_m, &TruthGrid::position_at)
          : RigidTransform{};
  std::vector<double> sizes_m;
  for (const ComparedJoint& joint : joints)
    for (std::size_t i = 0; i < joint.time_s.size(); ++i) {
      const double size_m = (turn * Vector3d(joint.estimate[i].position_m.cast<double>()) -
                             joint.truth->position_at(joint.time_s[i] + offset_s))
                                .norm();
      if (std::isfinite(size_m)) sizes_m.push_back(size_m);
    }
  return sizes_m.empty() ? kNaN : upper_median(sizes_m);
}

double residual_scale_m(const std::vector<ComparedJoint>& joints, double offset_s) {
  std::vector<double> sizes_m;
  for (const ComparedJoint& joint : joints)
    for (std::size_t i = 0; i < joint.time_s.size(); ++i) {
      const double size_m =
          (joint.estimate[i].high_pass_m.cast<double>() - joint.truth->quick_at(joint.time_s[i] + offset_s))
              .norm();
      if (std::isfinite(size_m)) sizes_m.push_back(size_m);
    }
  return sizes_m.empty() ? 0.0 : upper_median(sizes_m);
}

void add_evidence(const ComparedJoint& joint, double offset_s, double scale_m, double block_s,
                  Blocks& blocks) {
  for (std::size_t i = 0; i < joint.time_s.size(); ++i) {
    const double t = joint.time_s[i] + offset_s;
    const Vector3d off = joint.estimate[i].high_pass_m.cast<double>() - joint.truth->quick_at(t),
                   rate = joint.truth->rate_at(t);
    if (!off.allFinite() || !rate.allFinite()) continue;
    const double weight = scale_m > 0.0 ? 1.0 / (1.0 + off.squaredNorm() / (4.0 * scale_m * scale_m)) : 1.0;
    blocks[static_cast<std::int64_t>(std::floor(joint.time_s[i] / block_s))].add(
        {weight * rate.squaredNorm(), weight * rate.dot(off)});
  }
}

NormalEquation sum_of(const Blocks& blocks) {
  NormalEquation sum;
  for (const auto& [block, evidence] : blocks) sum.add(evidence);
  return sum;
}

struct Refined {
  double offset_s = kNaN, sigma_s = kNaN;
  std::size_t blocks = 0;
};

// Gauss-Newton on the positions, and the spread of what is found when each block is left out.
Refined refine(const std::vector<ComparedJoint>& joints, double offset_s, const ClockOffsetOptions& options) {
  Blocks blocks;
  for (int k = 0; k < 30; ++k) {
    blocks.clear();
    const double scale_m = residual_scale_m(joints, offset_s);
    for (const ComparedJoint& joint : joints) add_evidence(joint, offset_s, scale_m, options.block_s, blocks);
    const NormalEquation sum = sum_of(blocks);
    if (!(sum.information > 0.0)) return {};
    const double step_s = sum.gradient / sum.information;
    offset_s += step_s;
    if (std::abs(step_s) < 1e-9) break;
  }
  if (blocks.size() < 3) return {offset_s, kNaN, blocks.size()};
  const NormalEquation sum = sum_of(blocks);
  const double n = static_cast<double>(blocks.size());
  double squares = 0.0;
  for (const auto& [block, evidence] : blocks) {
    const double without = (sum.gradient - evidence.gradient) / (sum.information - evidence.information);
    squares += without * without;
  }
  return {offset_s, std::sqrt((n - 1.0) / n * squares), blocks.size()};
}

// Chooses among the peaks, of which there is one, and says how sure that is: found so far, or why there is
// none.
ClockOffsetStatus choose_peak(const std::vector<ComparedJoint>& joints, std::vector<Peak> peaks,
                              const ClockOffsetOptions& options, Peak& chosen, double& least_m) {
  chosen = peaks.front();
  if (!(chosen.value >= options.least_peak)) return ClockOffsetStatus::no_agreement;
  std::erase_if(peaks, [&](const Peak& p) { return p.value < options.largest_second * chosen.value; });
  if (options.frames == StreamFrames::shifted) {
    if (chosen.at_end) return ClockOffsetStatus::at_limit;
    return peaks.size() > 1 ? ClockOffsetStatus::ambiguous : ClockOffsetStatus::found;
  }
  double next_m = std::numeric_limits<double>::infinity();
  least_m = next_m;
  for (const Peak& peak : peaks) {
    const double apart_m = median_distance_m(joints, peak.step / options.grid_hz, options.frames);
    next_m = std::min(next_m, std::max(apart_m, least_m));
    if (!(apart_m < least_m)) continue;
    least_m = apart_m;
    chosen = peak;
  }
  if (!(least_m <= options.largest_misfit_m)) return ClockOffsetStatus::no_agreement;
  if (least_m > options.largest_misfit_ratio * next_m) return ClockOffsetStatus::ambiguous;
  return chosen.at_end ? ClockOffsetStatus::at_limit : ClockOffsetStatus::found;
}

double mean_speed_m_s(const std::vector<ComparedJoint>& joints) {
  double sum_m_s = 0.0, n = 0.0;
  for (const ComparedJoint& joint : joints)
    for (const float speed_m_s : joint.truth->speed_m_s)
      if (std::isfinite(speed_m_s)) {
        sum_m_s += static_cast<double>(speed_m_s);
        n += 1.0;
      }
  return n > 0.0 ? sum_m_s / n : kNaN;
}

std::vector<ComparedJoint> part_of(const std::vector<ComparedJoint>& joints, double from_s, double to_s) {
  std::vector<ComparedJoint> part;
  for (const ComparedJoint& joint : joints) {
    ComparedJoint piece{{}, {}, joint.truth};
    for (std::size_t i = 0; i < joint.time_s.size(); ++i)
      if (joint.time_s[i] >= from_s && joint.time_s[i] < to_s) {
        piece.time_s.push_back(joint.time_s[i]);
        piece.estimate.push_back(joint.estimate[i]);
      }
    part.push_back(std::move(piece));
  }
  return part;
}

void find_drift(const std::vector<ComparedJoint>& joints, const ClockOffsetOptions& options,
                ClockOffset& result) {
  double from_s = std::numeric_limits<double>::infinity(), to_s = -from_s;
  for (const ComparedJoint& joint : joints)
    if (!joint.time_s.empty()) {
      from_s = std::min(from_s, joint.time_s.front());
      to_s = std::max(to_s, joint.time_s.back());
    }
  const double third_s = (to_s - from_s) / 3.0;
  const Refined first = refine(part_of(joints, from_s, from_s + third_s), result.offset_s, options);
  const Refined last = refine(part_of(joints, to_s - third_s, to_s + 1.0), result.offset_s, options);
  result.drift_ppm = 1e6 * (last.offset_s - first.offset_s) / (2.0 * third_s);
  result.drift_sigma_ppm = 1e6 * std::hypot(first.sigma_s, last.sigma_s) / (2.0 * third_s);
}

}  // namespace

std::string_view name_of(ClockOffsetStatus status) {
  constexpr std::array<std::string_view, 7> kNames{
      "not_solved", "found", "too_little_motion", "no_agreement", "ambiguous", "at_limit", "too_uncertain"};
  return kNames.at(static_cast<std::size_t>(status));
}

ClockOffset find_clock_offset(std::vector<PointPath> estimate, std::span<const PointPath> truth,
                              const ClockOffsetOptions& options) {
  TRILAT_CHECK(estimate.size() == truth.size(), "both streams hold the same joints");
  std::vector<ComparedJoint> joints;
  for (std::size_t j = 0; j < estimate.size(); ++j) {
    ComparedJoint joint{estimate[j].time_s, {}, std::make_shared<TruthGrid>(grid_of(truth[j], options))};
    joint.estimate.reserve(joint.time_s.size());
    for (const double t : joint.time_s) joint.estimate.push_back(quick_motion(estimate[j], t, options));
    joints.push_back(std::move(joint));
    estimate[j] = {};  // of an hour its room is needed
  }
  ClockOffset result;
  result.speed_m_s = mean_speed_m_s(joints);
  const SpeedCurve curve(joints, options);
  const auto end_with = [&](ClockOffsetStatus status) {
    result.status = status;
    return result;
  };
  if (!curve.moves()) return end_with(ClockOffsetStatus::too_little_motion);
  const std::vector<Peak> peaks =
      peaks_of(curve, static_cast<int>(std::lround(options.search_s * options.grid_hz)), options);
  Peak chosen;
  const ClockOffsetStatus status = choose_peak(joints, peaks, options, chosen, result.median_distance_m);
  result.peak = chosen.value;
  result.second = 0.0;
  for (const Peak& peak : peaks)
    if (peak.step != chosen.step) result.second = std::max(result.second, peak.value / chosen.value);
  if (status != ClockOffsetStatus::found) return end_with(status);
  const double start_s = chosen.step / options.grid_hz;
  if (options.frames == StreamFrames::turned) {
    const RigidTransform turn =
        rotation_at(joints, start_s, &BandPassedMotion::high_pass_m, &TruthGrid::quick_at);
    for (ComparedJoint& joint : joints)
      for (BandPassedMotion& motion : joint.estimate)
        motion.high_pass_m = turn.rotation.cast<float>() * motion.high_pass_m;
  }
  const Refined refined = refine(joints, start_s, options);
  result.sigma_s = refined.sigma_s;
  if (!(refined.sigma_s <= options.largest_sigma_s) || std::abs(refined.offset_s - start_s) > 0.1)
    return end_with(ClockOffsetStatus::too_uncertain);
  result.offset_s = refined.offset_s;
  const double half_s = student_quantile(refined.blocks - 1) * refined.sigma_s;
  result.low_s = refined.offset_s - half_s;
  result.high_s = refined.offset_s + half_s;
  find_drift(joints, options, result);
  return end_with(ClockOffsetStatus::found);
}

}  // namespace trilat
