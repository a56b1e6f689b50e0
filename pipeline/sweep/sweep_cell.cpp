// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_cell.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include <Eigen/QR>

#include "datasets/base/error.h"
#include "evaluators/metrics/statistics.h"

namespace trilat {
namespace {

constexpr int kBinBits = 6;                        // of the mantissa
constexpr std::uint64_t kFirstOctave = 1023 - 40;  // 1e-12 m

// Sensors that stand off every plane by a thousandth of their spread: within kNear_m of the origin no
// geometry is rank deficient, so only answers beyond have to be asked.
constexpr double kMinThickness = 1e-6;  // of the scatter
constexpr double kNear_m = 100.0;

std::span<const Eigen::Vector3d> sensors_of(const RangeProblem& problem) {
  return {problem.sensor_m.data(), static_cast<std::size_t>(problem.count)};
}

}  // namespace

std::size_t Counts::quantile(double share) const {
  std::uint64_t all = 0, seen = 0;
  for (const std::uint64_t count : counts_) all += count;
  const auto rank = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(all)));
  for (std::size_t value = 0; value < counts_.size(); ++value) {
    seen += counts_[value];
    if (seen > 0 && seen >= rank) return value;
  }
  return 0;
}

double Counts::mean() const {
  std::uint64_t all = 0, sum = 0;
  for (std::size_t value = 0; value < counts_.size(); ++value) {
    all += counts_[value];
    sum += value * counts_[value];
  }
  return all == 0 ? kNaN : static_cast<double>(sum) / static_cast<double>(all);
}

std::size_t distance_bin(double distance_m) {
  const std::uint64_t bin = std::bit_cast<std::uint64_t>(distance_m) >> (52 - kBinBits);
  constexpr std::uint64_t first = kFirstOctave << kBinBits;
  return std::clamp(bin, first, first + kDistanceBins - 1) - first;
}

double bin_distance_m(std::size_t bin) {
  if (bin == 0) return 0.0;
  const std::uint64_t bits = (bin + (kFirstOctave << kBinBits)) << (52 - kBinBits);
  const double low = std::bit_cast<double>(bits);
  const double high = std::bit_cast<double>(bits + (std::uint64_t{1} << (52 - kBinBits)));
  return 0.5 * (low + high);
}

void SweepSums::add_start(const Eigen::Vector3d& from_m, const Eigen::Vector3d& truth_m) {
  const double off_m = (from_m - truth_m).norm();
  if (!std::isfinite(off_m)) return;
  ++starts;
  start_m += off_m;
}

void SweepSums::add(const Eigen::Vector3d& position_m, SolveStatus status, std::size_t steps,
                    const Eigen::Vector3d& truth_m) {
  ++asked;
  ++statuses[static_cast<std::size_t>(status)];
  iterations.add(steps);
  if (!is_usable(status)) return;
  ++answered;
  const Eigen::Vector3d off_m = (position_m - truth_m).cwiseAbs();
  for (std::size_t axis = 0; axis < 3; ++axis) axis_m[axis] += off_m[static_cast<Eigen::Index>(axis)];
  const double far_m = off_m.norm();
  distance_m += far_m;
  square_m2 += far_m * far_m;
  max_m = std::max(max_m, far_m);
  distance_bins.add(distance_bin(far_m));
}

void SweepSums::add(const SweepSums& later) {
  asked += later.asked;
  answered += later.answered;
  starts += later.starts;
  for (std::size_t i = 0; i < statuses.size(); ++i) statuses[i] += later.statuses[i];
  start_m += later.start_m;
  distance_m += later.distance_m;
  square_m2 += later.square_m2;
  max_m = std::max(max_m, later.max_m);
  for (std::size_t axis = 0; axis < 3; ++axis) axis_m[axis] += later.axis_m[axis];
  distance_bins.add(later.distance_bins);
  iterations.add(later.iterations);
}

Numbers numbers_of(const SweepSums& sums, const NumberKey& cell) {
  Numbers numbers;
  const auto asked = static_cast<double>(sums.asked), answered = static_cast<double>(sums.answered);
  const auto add = [&](const char* measure, const char* statistic, double value, std::uint64_t n) {
    numbers.add({cell.with({.measure = measure, .statistic = statistic}), value, kNaN, kNaN, n});
  };
  if (sums.answered > 0) {
    const double mean_m = sums.distance_m / answered, mean_square_m2 = sums.square_m2 / answered;
    Number mean{cell.with(kSweptError), mean_m};
    mean.n = mean.clusters = sums.answered;
    if (sums.answered > 1) {
      const double half_m = student_quantile(sums.answered - 1) *
                            std::sqrt(std::max(0.0, mean_square_m2 - mean_m * mean_m) / (answered - 1.0));
      mean.low = mean_m - half_m;
      mean.high = mean_m + half_m;
    }
    numbers.add(mean);
    add("distance", "rms", std::sqrt(mean_square_m2), sums.answered);
    for (const auto& [name, share] : {std::pair{"median", 0.5}, {"p95", 0.95}})
      add("distance", name, std::min(sums.max_m, bin_distance_m(sums.distance_bins.quantile(share))),
          sums.answered);
    add("distance", "max", sums.max_m, sums.answered);
    for (std::size_t axis = 0; axis < kAxisNames.size(); ++axis)
      add(kAxisNames[axis], "mean_abs", sums.axis_m[axis] / answered, sums.answered);
  }
  if (sums.starts > 0) add("start", "mean", sums.start_m / static_cast<double>(sums.starts), sums.starts);
  if (sums.asked == 0) return numbers;
  add("iterations", "mean", sums.iterations.mean(), sums.asked);
  for (const auto& [name, share] : {std::pair{"median", 0.5}, {"p99", 0.99}, {"max", 1.0}})
    add("iterations", name, static_cast<double>(sums.iterations.quantile(share)), sums.asked);
  add("answered", "share", answered / asked, sums.asked);
  for (std::size_t s = 0; s < sums.statuses.size(); ++s)
    if (sums.statuses[s] > 0)
      add("status", solve_status_names()[s].c_str(), static_cast<double>(sums.statuses[s]) / asked,
          sums.statuses[s]);
  return numbers;
}

// Row i: 2 (s_i - s_0).(x - s_0) = |s_i - s_0|^2 - r_i^2 + r_0^2.
LinearStart linear_start(const RangeProblem& problem) {
  const int rows = problem.count - 1;
  Eigen::Matrix<double, Eigen::Dynamic, 3> a(rows, 3);
  Eigen::VectorXd square_m2(rows);
  for (int i = 0; i < rows; ++i) {
    const Eigen::Vector3d from_reference_m = problem.sensor_m[i + 1] - problem.sensor_m[0];
    a.row(i) = 2.0 * from_reference_m.transpose();
    square_m2[i] = from_reference_m.squaredNorm();
  }
  const Eigen::MatrixXd inverse = a.colPivHouseholderQr().solve(Eigen::MatrixXd::Identity(rows, rows));
  const Eigen::Vector3d offset_m = problem.sensor_m[0] + inverse * square_m2;
  LinearStart start;
  for (int axis = 0; axis < 3; ++axis) {
    start.offset_m[axis] = offset_m[axis];
    start.factor_per_m[axis][0] = inverse.row(axis).sum();
    for (int i = 0; i < rows; ++i) start.factor_per_m[axis][i + 1] = -inverse(axis, i);
  }
  return start;
}

void LinearStart::positions(int sensors, std::size_t count, const AlignedRows& range_m,
                            AlignedRows& position_m) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double* to = position_m.row(axis);
    std::fill_n(to, count, offset_m[axis]);
    for (std::size_t s = 0; s < static_cast<std::size_t>(sensors); ++s) {
      const double factor = factor_per_m[axis][s];
      const double* r = range_m.row(s);
      for (std::size_t i = 0; i < count; ++i) to[i] += factor * (r[i] * r[i]);
    }
  }
}

SweepBlock::SweepBlock(const SweepTrials& cell)
    : cell_(cell),
      by_lanes_(cell.options.damping == Damping::none && !cell.plane.exact),
      is_thick_(cell.plane.scatter_m2[0] > kMinThickness * cell.plane.scatter_m2[2]),
      lanes_(sensors_of(cell.sensors), kBlockTrials),
      truth_m_(3, kBlockTrials),
      mean_m_(3, kBlockTrials) {
  cell_.sensors.range_m.fill(0.0);
  if (by_lanes_ && is_thick_ && cell.start == SweepStart::linear) linear_ = linear_start(cell.sensors);
}

void SweepBlock::make_trials(std::uint64_t first_trial, std::size_t count) {
  TRILAT_CHECK(count <= kBlockTrials, "a block has room for its trials");
  lanes_.count = count;
  problems_made_ = 0;
  RangeTrialRows rows;
  rows.stride = truth_m_.stride();
  rows.truth_m = truth_m_.row(0);
  rows.range_m = lanes_.range_m.row(0);
  if (cell_.has_guess) rows.mean_m = mean_m_.row(0);
  make_range_trials(cell_.model, first_trial, count, rows);
}

std::span<const RangeProblem> SweepBlock::problems() {
  if (problems_made_ == lanes_.count) return problems_;
  problems_.assign(lanes_.count, cell_.sensors);
  for (std::size_t i = 0; i < lanes_.count; ++i) {
    for (std::size_t s = 0; s < lanes_.sensor_m.size(); ++s)
      problems_[i].range_m[s] = lanes_.range_m.row(s)[i];
    if (cell_.has_guess) problems_[i].guess_m = mean_m_.position(i);
  }
  problems_made_ = lanes_.count;
  return problems_;
}

void SweepBlock::find_starts() {
  if (linear_)
    return linear_->positions(cell_.sensors.count, lanes_.count, lanes_.range_m, lanes_.position_m);
  const auto all = problems();
  for (std::size_t i = 0; i < all.size(); ++i)
    lanes_.position_m.set_position(i, requested_start_m(all[i], cell_.plane, cell_.options.start,
                                                        cell_.options.start_point_m, cell_.options.linear));
}

// Whether an answer is where the directions to the sensors do not span space, as solve_nonlinear() asks.
bool SweepBlock::is_far_off(std::size_t trial) const {
  const Eigen::Vector3d x_m = lanes_.position_m.position(trial);
  if (is_thick_ && x_m.cwiseAbs().maxCoeff() <= kNear_m) return false;
  return !std::isfinite(estimate_at(cell_.sensors, x_m, SolveStatus::converged, 0).gdop);
}

void SweepBlock::solve() {
  if (by_lanes_) {
    descend(lanes_, cell_.options);
    for (std::size_t i = 0; i < lanes_.count; ++i)
      if (is_usable(lanes_.status[i]) && is_far_off(i)) lanes_.status[i] = SolveStatus::rank_deficient;
    return;
  }
  const auto all = problems();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const PointEstimate estimate = solve_nonlinear(all[i], cell_.options);
    lanes_.position_m.set_position(i, estimate.position_m);
    lanes_.iterations.row(0)[i] = estimate.iterations;
    lanes_.status[i] = estimate.status;
  }
}

void SweepBlock::solve_into(SweepSums& sums) {
  find_starts();
  for (std::size_t i = 0; i < lanes_.count; ++i)
    sums.add_start(lanes_.position_m.position(i), truth_m_.position(i));
  solve();
  for (std::size_t i = 0; i < lanes_.count; ++i)
    sums.add(lanes_.position_m.position(i), lanes_.status[i],
             static_cast<std::size_t>(lanes_.iterations.row(0)[i]), truth_m_.position(i));
}

}  // namespace trilat
