// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_block.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include <Eigen/QR>

#include "datasets/base/error.h"
#include "evaluators/solvers/range_equations.h"

namespace trilat {
namespace {

constexpr int kBinBits = 6;                        // of the mantissa
constexpr std::uint64_t kFirstOctave = 1023 - 40;  // 1e-12 m
constexpr std::size_t kLanes = 8;

// Eight sums side by side, added up in one order whatever the processor does at once.
struct LaneSums {
  std::array<double, kLanes> of{};
  double total() const { return ((of[0] + of[4]) + (of[2] + of[6])) + ((of[1] + of[5]) + (of[3] + of[7])); }
};

}  // namespace

std::uint64_t Counts::all() const {
  std::uint64_t all = 0;
  for (const std::uint64_t count : counts_) all += count;
  return all;
}

std::size_t Counts::quantile(double share) const {
  const auto rank = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(all())));
  std::uint64_t seen = 0;
  for (std::size_t value = 0; value < counts_.size(); ++value) {
    seen += counts_[value];
    if (seen > 0 && seen >= rank) return value;
  }
  return 0;
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

void SweepCounts::add(const SweepCounts& other) {
  asked += other.asked;
  starts += other.starts;
  for (std::size_t i = 0; i < statuses.size(); ++i) statuses[i] += other.statuses[i];
  max_m = std::max(max_m, other.max_m);
  distance_bins.add(other.distance_bins);
  iteration_counts.add(other.iteration_counts);
}

void SweepSums::add(const SweepSums& later) {
  counts.add(later.counts);
  for (std::size_t term = 0; term < sum.size(); ++term) sum[term] += later.sum[term];
}

void SweepSums::add_starts(const SweepOutcomeRows& rows) {
  LaneSums sums;
  for (std::size_t i = 0; i < rows.count; ++i) {
    const double dx = rows.position_m[i] - rows.truth_m[i];
    const double dy = rows.position_m[rows.stride + i] - rows.truth_m[rows.stride + i];
    const double dz = rows.position_m[2 * rows.stride + i] - rows.truth_m[2 * rows.stride + i];
    const double distance_m = std::sqrt(dx * dx + dy * dy + dz * dz);
    const bool finite = std::isfinite(distance_m);
    sums.of[i % kLanes] += finite ? distance_m : 0.0;
    counts.starts += finite ? 1 : 0;
  }
  sum[start] += sums.total();
}

void SweepSums::add_outcomes(const SweepOutcomeRows& rows) {
  std::array<LaneSums, kTerms> sums;
  counts.asked += rows.count;
  for (std::size_t i = 0; i < rows.count; ++i) {
    ++counts.statuses[static_cast<std::size_t>(rows.status[i])];
    const std::size_t lane = i % kLanes;
    sums[iterations].of[lane] += rows.iterations[i];
    counts.iteration_counts.add(static_cast<std::size_t>(rows.iterations[i]));
    if (!is_usable(rows.status[i])) continue;
    const double dx = std::abs(rows.position_m[i] - rows.truth_m[i]);
    const double dy = std::abs(rows.position_m[rows.stride + i] - rows.truth_m[rows.stride + i]);
    const double dz = std::abs(rows.position_m[2 * rows.stride + i] - rows.truth_m[2 * rows.stride + i]);
    const double square_m2 = dx * dx + dy * dy + dz * dz;
    const double distance_m = std::sqrt(square_m2);
    sums[x].of[lane] += dx;
    sums[y].of[lane] += dy;
    sums[z].of[lane] += dz;
    sums[distance].of[lane] += distance_m;
    sums[square].of[lane] += square_m2;
    counts.max_m = std::max(counts.max_m, distance_m);
    counts.distance_bins.add(distance_bin(distance_m));
  }
  for (const Term term : {x, y, z, distance, square, iterations}) sum[term] += sums[term].total();
}

SweepCell cell_of(const SweepSums& sums) {
  const SweepCounts& counts = sums.counts;
  SweepCell cell;
  cell.asked = counts.asked;
  for (std::size_t i = 0; i < counts.statuses.size(); ++i) {
    if (counts.statuses[i] == 0) continue;
    cell.statuses[std::string(name_of(static_cast<SolveStatus>(i)))] = counts.statuses[i];
    if (is_usable(static_cast<SolveStatus>(i))) cell.answered += counts.statuses[i];
  }
  const auto mean = [&](SweepSums::Term term, std::uint64_t n) {
    return sums.sum[term] / static_cast<double>(n);
  };
  if (counts.starts > 0) cell.start_mae_m = mean(SweepSums::start, counts.starts);
  if (cell.asked > 0) {
    cell.mean_iterations = mean(SweepSums::iterations, cell.asked);
    cell.p50_iterations = static_cast<double>(counts.iteration_counts.quantile(0.5));
    cell.p99_iterations = static_cast<double>(counts.iteration_counts.quantile(0.99));
    cell.max_iterations = static_cast<double>(counts.iteration_counts.quantile(1.0));
  }
  const std::uint64_t n = cell.answered;
  if (n == 0) return cell;
  cell.mae_m = mean(SweepSums::distance, n);
  cell.axis_mae_m = {mean(SweepSums::x, n), mean(SweepSums::y, n), mean(SweepSums::z, n)};
  const double mean_square_m2 = mean(SweepSums::square, n);
  cell.rmse_m = std::sqrt(mean_square_m2);
  if (n > 1)
    cell.mae_standard_error_m =
        std::sqrt(std::max(0.0, mean_square_m2 - cell.mae_m * cell.mae_m) / (static_cast<double>(n) - 1.0));
  cell.p50_m = std::min(counts.max_m, bin_distance_m(counts.distance_bins.quantile(0.5)));
  cell.p95_m = std::min(counts.max_m, bin_distance_m(counts.distance_bins.quantile(0.95)));
  cell.max_m = counts.max_m;
  return cell;
}

namespace {

// Sensors that stand off every plane by a thousandth of their spread: within kNear_m of the origin no
// geometry is rank deficient, so only answers beyond have to be asked.
constexpr double kMinThickness = 1e-6;  // of the scatter
constexpr double kNear_m = 100.0;
constexpr int kFirstStage = 32;  // iterations; each further stage is as long as all before

Eigen::Vector3d column(const LaneRows& rows, std::size_t i) {
  return {rows.row(0)[i], rows.row(1)[i], rows.row(2)[i]};
}

void set_column(LaneRows& rows, std::size_t i, const Eigen::Vector3d& x_m) {
  for (int axis = 0; axis < 3; ++axis) rows.row(static_cast<std::size_t>(axis))[i] = x_m[axis];
}

void copy_lanes(const LaneRows& from, const std::vector<std::size_t>& lanes, std::size_t rows, LaneRows& to) {
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t i = 0; i < lanes.size(); ++i) to.row(r)[i] = from.row(r)[lanes[i]];
}

}  // namespace

SweepCellSolver solver_of(const SweepTrials& trials) {
  SweepCellSolver cell{trials, false, {}};
  const bool thick = cell.plane.scatter_m2[0] > kMinThickness * cell.plane.scatter_m2[2];
  cell.straight = thick && cell.options.damping == Damping::none && cell.start != SweepStart::squared_ranges;
  if (cell.straight && cell.start == SweepStart::linear) cell.linear = linear_start(cell.sensors);
  return cell;
}

SweepBlock::SweepBlock(int sensors)
    : batch_(sensors, kBlockTrials, true),
      unfinished_(sensors, kBlockTrials, true),
      truth_m_(3, kBlockTrials),
      mean_m_(3, kBlockTrials) {}

void SweepBlock::make_trials(const SweepCellSolver& cell, std::uint64_t first_trial, std::size_t count) {
  TRILAT_CHECK(count <= kBlockTrials && cell.model.sensors == sensors(), "a block has room for its trials");
  batch_.count = count;
  problems_are_made_ = false;
  for (std::size_t i = 0; i < static_cast<std::size_t>(sensors()); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      batch_.sensor_m.row(3 * i + axis)[0] = unfinished_.sensor_m.row(3 * i + axis)[0] =
          cell.model.sensor_m[i][axis];
  RangeTrialRows rows;
  rows.stride = truth_m_.stride();
  rows.truth_m = truth_m_.row(0);
  rows.range_m = batch_.range_m.row(0);
  if (cell.has_hint) rows.mean_m = mean_m_.row(0);
  make_range_trials(cell.model, first_trial, count, rows);
}

std::span<const RangeProblem> SweepBlock::problems(const SweepCellSolver& cell) {
  if (problems_are_made_) return {problems_.data(), batch_.count};
  problems_.assign(batch_.count, cell.sensors);
  for (std::size_t i = 0; i < batch_.count; ++i) {
    for (std::size_t s = 0; s < static_cast<std::size_t>(sensors()); ++s)
      problems_[i].range_m[s] = batch_.range_m.row(s)[i];
    if (cell.has_hint) problems_[i].hint_m = column(mean_m_, i);
  }
  problems_are_made_ = true;
  return {problems_.data(), batch_.count};
}

SweepOutcomeRows SweepBlock::rows() const {
  return {batch_.count,
          truth_m_.stride(),
          truth_m_.row(0),
          batch_.position_m.row(0),
          batch_.iterations.row(0),
          batch_.status.data()};
}

void SweepBlock::find_starts(const SweepCellSolver& cell) {
  if (cell.straight && cell.start == SweepStart::linear) {
    cell.linear.positions(sensors(), batch_.count, truth_m_.stride(), batch_.range_m.row(0),
                          batch_.position_m.row(0));
    return;
  }
  const auto all = problems(cell);
  for (std::size_t i = 0; i < all.size(); ++i)
    set_column(batch_.position_m, i,
               wanted_start_m(all[i], cell.plane, cell.options.start, cell.options.start_point_m,
                              cell.options.linear));
}

// Lanes that are done wait for the slowest of their vector. So every stage gathers those that are not: an
// undamped descent has no memory but its position, and goes on as if it had not been stopped.
void SweepBlock::descend_in_stages(const DescentOptions& options) {
  DescentOptions stage = options;
  stage.max_iterations = std::min(options.max_iterations, kFirstStage);
  descend(batch_, stage);
  for (int done = stage.max_iterations; done < options.max_iterations; done += stage.max_iterations) {
    unfinished_lanes_.clear();
    for (std::size_t i = 0; i < batch_.count; ++i)
      if (batch_.status[i] == SolveStatus::iteration_limit) unfinished_lanes_.push_back(i);
    if (unfinished_lanes_.empty()) return;
    unfinished_.count = unfinished_lanes_.size();
    copy_lanes(batch_.range_m, unfinished_lanes_, static_cast<std::size_t>(sensors()), unfinished_.range_m);
    copy_lanes(batch_.position_m, unfinished_lanes_, 3, unfinished_.position_m);
    stage.max_iterations = std::min(done, options.max_iterations - done);
    descend(unfinished_, stage);
    for (std::size_t i = 0; i < unfinished_lanes_.size(); ++i) {
      const std::size_t lane = unfinished_lanes_[i];
      set_column(batch_.position_m, lane, column(unfinished_.position_m, i));
      batch_.iterations.row(0)[lane] = done + unfinished_.iterations.row(0)[i];
      batch_.status[lane] = unfinished_.status[i];
    }
  }
}

// Refuses, as solve_nonlinear() does, answers from where the directions to the sensors do not span space.
void SweepBlock::refuse_far_answers(const SweepCellSolver& cell) {
  const double* coordinate_m = batch_.position_m.row(0);
  double farthest_m = 0.0;
  for (std::size_t i = 0; i < 3 * truth_m_.stride(); ++i)  // columns that are not in use do no harm
    farthest_m = std::max(farthest_m, std::abs(coordinate_m[i]));
  if (farthest_m <= kNear_m) return;
  const auto all = problems(cell);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Eigen::Vector3d x_m = column(batch_.position_m, i);
    if (!is_usable(batch_.status[i]) || x_m.cwiseAbs().maxCoeff() <= kNear_m) continue;
    if (!std::isfinite(estimate_at(all[i], x_m, batch_.status[i], 0).gdop))
      batch_.status[i] = SolveStatus::rank_deficient;
  }
}

void SweepBlock::solve_one_by_one(const SweepCellSolver& cell) {
  const auto all = problems(cell);
  estimates_.resize(all.size());
  solve_nonlinear(all, cell.options, estimates_);
  for (std::size_t i = 0; i < all.size(); ++i) {
    set_column(batch_.position_m, i, estimates_[i].position_m);
    batch_.iterations.row(0)[i] = estimates_[i].iterations;
    batch_.status[i] = estimates_[i].status;
  }
}

void SweepBlock::solve_into(const SweepCellSolver& cell, SweepSums& sums) {
  find_starts(cell);
  sums.add_starts(rows());
  if (cell.straight) {
    descend_in_stages(cell.options);
    refuse_far_answers(cell);
  } else {
    solve_one_by_one(cell);
  }
  sums.add_outcomes(rows());
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

void LinearStart::positions(int sensors, std::size_t count, std::size_t stride, const double* range_m,
                            double* position_m) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double* to = position_m + axis * stride;
    std::fill_n(to, count, offset_m[axis]);
    for (std::size_t s = 0; s < static_cast<std::size_t>(sensors); ++s) {
      const double factor = factor_per_m[axis][s];
      const double* r = range_m + s * stride;
      for (std::size_t i = 0; i < count; ++i) to[i] += factor * (r[i] * r[i]);
    }
  }
}

}  // namespace trilat
