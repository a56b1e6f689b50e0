// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/joint_effect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"
#include "evaluators/metrics/cluster_ratios.h"
#include "evaluators/metrics/error_statistics.h"
#include "evaluators/solvers/linear.h"
#include "evaluators/solvers/nonlinear.h"
#include "evaluators/solvers/precision.h"

namespace trilat {
namespace {

constexpr std::size_t kBlocks = 50;  // of assumed sensor errors: clusters of the interval, each with its own
const std::array<const char*, 3> kMethods{"nonlinear", "linear", "mean"};

struct Trial {
  Eigen::Vector3d joint_m;
  std::vector<Eigen::Vector3d>
      seen_m;  // the joint as each sensor truly sees it, with its range error along the ray
  std::vector<double> range_m;
};

// Joints within 0.6 m of the middle horizontally and 0.1 to 1.9 m high, as in the threshold sweeps.
Trial draw_trial(const CalibrationSpec& spec, const std::vector<RigidTransform>& truth, std::uint64_t index) {
  const RandomStream random{spec.seed, Purpose::calibration_trial, random_item(0, 1, 0, index)};
  Trial trial;
  const double x = random.uniform(0, -0.6, 0.6), z = random.uniform(1, -0.6, 0.6);
  trial.joint_m = {x, random.uniform(2, 0.1, 1.9), z};
  for (std::size_t s = 0; s < truth.size(); ++s) {
    const Eigen::Vector3d in_sensor_m = truth[s].inverse() * trial.joint_m;
    const double error_m = spec.range_sigma_m * random.normal(static_cast<std::uint32_t>(10 + s));
    trial.range_m.push_back(std::max(0.0, in_sensor_m.norm() + error_m));
    trial.seen_m.push_back(in_sensor_m.normalized() * trial.range_m.back());
  }
  return trial;
}

struct Sums {
  std::array<double, kMethods.size()> squares_m2{}, counts{};
  double bound_m2 = 0.0, asked = 0.0;
};

// What the sensors' positions are believed to be in one block of trials, and with which covariance.
struct Case {
  std::string name;
  double sigma_m = 0.0;
  std::vector<CalibratedRig> rigs;  // one a block of trials, the clusters of the interval
};

Case assumed_case(const CalibrationSpec& spec, const std::vector<RigidTransform>& truth, double sigma_m) {
  Case c{sigma_m == 0.0 ? "exact" : fmt::format("{:g} mm an axis", 1e3 * sigma_m), sigma_m, {}};
  for (std::size_t b = 0; b < kBlocks; ++b) {
    CalibratedRig rig{truth};
    for (std::size_t s = 0; s < truth.size(); ++s) {
      const RandomStream random{spec.seed, Purpose::calibration_trial, random_item(0, 2, s, b)};
      for (int axis = 0; axis < 3; ++axis)
        rig.world_from_sensor[s].translation_m[axis] +=
            sigma_m * random.normal(static_cast<std::uint32_t>(axis));
    }
    c.rigs.push_back(std::move(rig));
  }
  return c;
}

Case found_case(const std::vector<RigidTransform>& truth, const RigCalibrations& calibrations) {
  Case c{calibrations.method, 0.0, calibrations.runs};
  double squares_m2 = 0.0, axes = 0.0;
  for (const CalibratedRig& rig : calibrations.runs)
    for (std::size_t s = 0; s < truth.size(); ++s, axes += 3.0)
      squares_m2 += (rig.world_from_sensor[s].translation_m - truth[s].translation_m).squaredNorm();
  c.sigma_m = std::sqrt(squares_m2 / axes);
  return c;
}

RangeProblem problem_of(const Trial& trial, const CalibratedRig& rig) {
  RangeProblem problem;
  problem.count = static_cast<int>(trial.range_m.size());
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  for (std::size_t s = 0; s < trial.range_m.size(); ++s) {
    problem.sensor_m[s] = rig.world_from_sensor[s].translation_m;
    problem.range_m[s] = trial.range_m[s];
    mean_m += rig.world_from_sensor[s] * trial.seen_m[s] / static_cast<double>(trial.range_m.size());
  }
  problem.hint_m = mean_m;
  return problem;
}

// Bound of one trial: its ranges, and sensors that are uncertain by sigma an axis.
double bound_m2(const Trial& trial, const std::vector<RigidTransform>& truth, double range_sigma_m,
                double sensor_sigma_m) {
  RangeProblem problem = problem_of(trial, {truth});
  const std::vector<double> variances(trial.range_m.size(), range_sigma_m * range_sigma_m);
  const std::vector<Eigen::Matrix3d> covariances(
      trial.range_m.size(), sensor_sigma_m * sensor_sigma_m * Eigen::Matrix3d::Identity());
  return precision_at(problem, trial.joint_m, variances, covariances).covariance_m2.trace();
}

Sums run_block(const CalibrationSpec& spec, const std::vector<RigidTransform>& truth, const Case& c,
               std::size_t block) {
  Sums sums;
  const CalibratedRig& rig = c.rigs[block];
  std::vector<Trial> trials;
  std::vector<RangeProblem> problems;
  for (std::uint64_t i = block; i < spec.effect_joints; i += c.rigs.size()) {
    trials.push_back(draw_trial(spec, truth, i));
    problems.push_back(problem_of(trials.back(), rig));
  }
  std::vector<PointEstimate> estimates(problems.size());
  solve_nonlinear(problems, NonlinearOptions{}, estimates);
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const PointEstimate linear = solve_linear(problems[i], LinearOptions{});
    const auto add = [&](std::size_t method, const Eigen::Vector3d& position_m) {
      sums.squares_m2[method] += (position_m - trials[i].joint_m).squaredNorm();
      sums.counts[method] += 1.0;
    };
    if (is_usable(estimates[i].status)) add(0, estimates[i].position_m);
    if (is_usable(linear.status)) add(1, linear.position_m);
    add(2, *problems[i].hint_m);
    sums.bound_m2 += bound_m2(trials[i], truth, spec.range_sigma_m, c.sigma_m);
    sums.asked += 1.0;
  }
  return sums;
}

EffectRow row_of(const CalibrationSpec& spec, const Case& c, const std::vector<Sums>& blocks,
                 std::size_t method) {
  EffectRow row;
  row.calibration = c.name;
  row.sensor_sigma_m = c.sigma_m;
  row.range_sigma_m = spec.range_sigma_m;
  row.method = kMethods[method];
  double squares_m2 = 0.0, count = 0.0, bound_total_m2 = 0.0, asked = 0.0;
  std::vector<double> ratios, weights;
  for (const Sums& block : blocks) {
    squares_m2 += block.squares_m2[method];
    count += block.counts[method];
    bound_total_m2 += block.bound_m2;
    asked += block.asked;
  }
  row.joints = static_cast<std::uint64_t>(asked);
  row.answered = static_cast<std::uint64_t>(count);
  if (count == 0.0) return row;
  row.rmse_m = std::sqrt(squares_m2 / count);
  if (spec.rig.heights_m.size() < 3) return row;  // they do not determine a place: there is no bound
  row.bound_m = std::sqrt(bound_total_m2 / asked);
  for (const Sums& block : blocks) {
    ratios.push_back(block.squares_m2[method] / (bound_total_m2 / asked));
    weights.push_back(block.counts[method]);
  }
  const auto [low, high] = bootstrap_mean(ratios, weights, spec.seed);
  row.ratio_low = std::sqrt(low);
  row.ratio_high = std::sqrt(high);
  return row;
}

}  // namespace

std::vector<EffectRow> measure_effect(const CalibrationSpec& spec, const std::vector<RigidTransform>& truth,
                                      std::span<const RigCalibrations> calibrations, const Watch& watch) {
  std::vector<EffectRow> rows;
  if (spec.effect_joints < kBlocks) return rows;
  std::vector<Case> cases;
  for (double sigma_m : spec.sensor_sigmas_m) cases.push_back(assumed_case(spec, truth, sigma_m));
  for (const RigCalibrations& c : calibrations)
    if (!c.runs.empty()) cases.push_back(found_case(truth, c));
  for (std::size_t c = 0; c < cases.size(); ++c) {
    std::vector<Sums> blocks;
    for (std::size_t b = 0; b < cases[c].rigs.size(); ++b) {
      watch.check();
      blocks.push_back(run_block(spec, truth, cases[c], b));
    }
    for (std::size_t m = 0; m < kMethods.size(); ++m) rows.push_back(row_of(spec, cases[c], blocks, m));
    watch.tell(static_cast<double>(c + 1) / static_cast<double>(cases.size()));
  }
  return rows;
}

ErrorSpread spread_of(const std::vector<ClusteredError>& errors, std::uint64_t seed) {
  ErrorSpread spread;
  std::map<std::size_t, std::pair<double, double>> clusters;  // sum, count
  std::vector<double> answered;
  CompensatedSum sum, squares;
  for (const ClusteredError& e : errors) {
    ++spread.asked;
    if (!std::isfinite(e.error_m)) continue;
    answered.push_back(e.error_m);
    sum.add(e.error_m);
    clusters[e.cluster].first += e.error_m;
    clusters[e.cluster].second += 1.0;
  }
  spread.answered = answered.size();
  if (answered.empty()) return spread;
  const double n = static_cast<double>(answered.size());
  spread.mean_m = sum.value() / n;
  for (double error : answered) squares.add((error - spread.mean_m) * (error - spread.mean_m));
  if (answered.size() > 1) spread.sd_m = std::sqrt(squares.value() / (n - 1.0));
  const auto q = quantiles_of(answered, {0.5, 0.95, 1.0});
  spread.median_m = q[0];
  spread.p95_m = q[1];
  spread.max_m = q[2];
  std::vector<double> sums, counts;
  for (const auto& [cluster, s] : clusters) {
    sums.push_back(s.first);
    counts.push_back(s.second);
  }
  std::tie(spread.mean_low_m, spread.mean_high_m) = bootstrap_mean(sums, counts, seed);
  return spread;
}

PoseMisfit misfit_of(const Eigen::Matrix<double, 6, 1>& error,
                     const Eigen::Matrix<double, 6, 6>& covariance) {
  constexpr double kNormal95 = 1.959964;
  const Eigen::Array<double, 6, 1> z2 = error.array().square() / covariance.diagonal().array();
  PoseMisfit misfit{z2.head<3>().mean(), z2.tail<3>().mean(), error.dot(covariance.ldlt().solve(error)), 0,
                    6};
  for (const double axis : z2) misfit.covered += axis <= kNormal95 * kNormal95;
  return misfit;
}

}  // namespace trilat
