// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/rig_trials.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/units.h"
#include "evaluators/calibration/wand_positions.h"
#include "evaluators/metrics/share.h"
#include "pipeline/calibration/calibrate_bodies.h"
#include "pipeline/calibration_study/simulated_run.h"
#include "pipeline/calibration_study/wand_samples.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr double kGoodPosition_m = 0.005, kGoodRotation_rad = 0.2 * kRadPerDegree;
constexpr double kGoodBodies_m = 0.02, kGoodBodies_rad = 0.5 * kRadPerDegree;

struct Method {
  const char* name;
  enum class Kind { two_positions, wand, bodies } kind;
  TwoPositionOptions two = {};
  bool upright = true;  // two positions: the sensors are taken to stand upright, as in the paper
};

std::vector<Method> methods() {
  using Kind = Method::Kind;
  const TwoPositionOptions printed, corrected{TrajectoryAxis::z, true, true, Eigen::Vector3d::UnitY()};
  TwoPositionOptions e4 = corrected, e5 = corrected;
  e4.signed_angle = false;
  e5.translation = false;
  return {{"two positions, eq. 6 and 7 as printed", Kind::two_positions, printed},
          {"corrected, but E4 as printed", Kind::two_positions, e4, false},
          {"corrected, but E5 as printed", Kind::two_positions, e5, false},
          {"two positions, corrected", Kind::two_positions, corrected, false},
          {"wand", Kind::wand},
          {"bodies", Kind::bodies}};
}

// One sensor's error in one run.
struct PoseError {
  double position_m = ErrorSpread::kNone, rotation_rad = ErrorSpread::kNone;
  PoseMisfit misfit = {};
  TRILAT_FIELDS(position_m, rotation_rad, misfit)
};

struct RunOutcome {
  bool failed = true;  // at least one sensor has no pose
  double reduced_chi2 = ErrorSpread::kNone;
  std::vector<PoseError> sensors;
  TRILAT_FIELDS(failed, reduced_chi2, sensors)
};

// One run, by method.
struct RunOutcomes {
  std::vector<RunOutcome> methods;
  TRILAT_FIELDS(methods)
};

// None of the sensors that were asked for has a pose.
RunOutcome failed_run(std::size_t sensors) {
  RunOutcome outcome;
  outcome.sensors.resize(sensors);
  return outcome;
}

PoseError error_of(const RigidTransform& got, const RigidTransform& truth,
                   const std::optional<Eigen::Matrix<double, 6, 6>>& covariance) {
  PoseError error;
  const Eigen::AngleAxisd turn(got.rotation * truth.rotation.conjugate());
  Eigen::Matrix<double, 6, 1> off;
  off << turn.angle() * turn.axis(), got.translation_m - truth.translation_m;
  error.position_m = off.tail<3>().norm();
  error.rotation_rad = off.head<3>().norm();
  if (covariance) error.misfit = misfit_of(off, *covariance);
  return error;
}

// `frame_from_world` is the truth's frame in which the poses were found.
RunOutcome compare(const Calibration& calibration, const RigidTransform& frame_from_world,
                   const std::vector<RigidTransform>& truth) {
  const std::vector<SensorPose>& poses = calibration.sensors;
  RunOutcome outcome;
  outcome.failed = false;
  outcome.reduced_chi2 = calibration.reduced_chi2.value_or(ErrorSpread::kNone);
  for (std::size_t s = 0; s < truth.size(); ++s)
    outcome.sensors.push_back(
        error_of(poses[s].world_from_sensor, frame_from_world * truth[s], poses[s].covariance));
  return outcome;
}

const RestingBall* ball_at(const SimulatedRun& run, std::size_t position, std::size_t sensor) {
  for (const RestingBall& ball : run.views.positions[position].seen)
    if (ball.sensor == sensor) return &ball;
  return nullptr;
}

// Each sensor by itself: those that did not see both places, or have no angle, are left without a pose.
RunOutcome run_two_positions(const SimulatedRun& run, const Method& method,
                             const std::vector<RigidTransform>& truth) {
  RunOutcome outcome;
  outcome.sensors.resize(truth.size());
  if (run.views.positions.size() < 2) return outcome;
  outcome.failed = false;
  for (std::size_t s = 0; s < truth.size(); ++s) {
    const RestingBall *first = ball_at(run, 0, s), *second = ball_at(run, 1, s);
    TwoPositionOptions options = method.two;
    if (!method.upright) options.up_in_sensor = truth[s].rotation.conjugate() * Eigen::Vector3d::UnitY();
    TwoPositionPose pose;
    if (first && second)
      pose =
          solve_two_positions(first->centre_in_sensor_m, second->centre_in_sensor_m, run.movement_m, options);
    if (pose.status != TwoPositionStatus::solved) {
      outcome.failed = true;
      continue;
    }
    outcome.sensors[s] = error_of(pose.wand_from_sensor, run.wand_from_world * truth[s], std::nullopt);
  }
  return outcome;
}

RunOutcome run_wand(const CalibrationSpec& spec, const SimulatedRun& run,
                    const std::vector<RigidTransform>& truth) {
  CalibrateWandOptions options;
  options.search.find.ball_radius_m = spec.ball_radius_m;
  try {
    const WandCalibration result = calibrate_views(run.views, "simulated run", options);
    return compare(result.calibration, run.wand_from_world, truth);
  } catch (const InputError&) {
    return failed_run(truth.size());
  }
}

struct RemovedAtEnd {
  std::filesystem::path path;
  ~RemovedAtEnd() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
};

// Bodies place the sensors beside each other; the truth is taken to where the best seen one was put.
RunOutcome run_bodies(const CalibrationSpec& spec, std::uint64_t run,
                      const std::vector<RigidTransform>& truth, const std::filesystem::path& scratch) {
  const auto session = scratch / fmt::format("walk-{}.h5", run);
  const RemovedAtEnd removed{session};
  write_walk(spec, truth, run, default_body_tracker(), session);
  RunOutcome outcome;
  try {
    const BodyCalibration result = calibrate_bodies(session, {.instants = spec.bodies_instants});
    const auto& poses = result.calibration.sensors;
    const std::size_t reference = result.reference;
    outcome =
        compare(result.calibration, poses[reference].world_from_sensor * truth[reference].inverse(), truth);
    outcome.sensors.erase(outcome.sensors.begin() + static_cast<std::ptrdiff_t>(reference));
  } catch (const InputError&) {
    outcome = failed_run(truth.size() - 1);
  }
  return outcome;
}

// How right what the poses of one method state of themselves is, over all runs.
void add_misfits(const std::vector<RunOutcome>& outcomes, RigRow& row) {
  std::vector<double> covered, asked;  // of each run that states something
  double position_z2 = 0.0, rotation_z2 = 0.0, mahalanobis2 = 0.0, poses = 0.0;
  double chi2 = 0.0, runs_with_chi2 = 0.0;
  for (const RunOutcome& outcome : outcomes) {
    double run_covered = 0.0, run_asked = 0.0;
    for (const PoseError& e : outcome.sensors) {
      if (e.misfit.asked == 0) continue;
      poses += 1.0;
      position_z2 += e.misfit.position_z2;
      rotation_z2 += e.misfit.rotation_z2;
      mahalanobis2 += e.misfit.mahalanobis2;
      run_covered += static_cast<double>(e.misfit.covered);
      run_asked += static_cast<double>(e.misfit.asked);
    }
    if (run_asked == 0.0) continue;
    covered.push_back(run_covered);
    asked.push_back(run_asked);
    if (std::isnan(outcome.reduced_chi2)) continue;  // a pose that is determined just so has none
    chi2 += outcome.reduced_chi2;
    runs_with_chi2 += 1.0;
  }
  if (asked.empty()) return;
  row.coverage_share =
      std::accumulate(covered.begin(), covered.end(), 0.0) / std::accumulate(asked.begin(), asked.end(), 0.0);
  const ShareEstimate share = estimate_share(covered, asked);
  row.coverage_low = share.low;
  row.coverage_high = share.high;
  row.position_z_rms = std::sqrt(position_z2 / poses);
  row.rotation_z_rms = std::sqrt(rotation_z2 / poses);
  row.mahalanobis2_mean = mahalanobis2 / poses;
  row.reduced_chi2_mean = chi2 / runs_with_chi2;
}

RigRow row_of(const Method& method, const std::vector<RunOutcome>& outcomes) {
  RigRow row;
  row.method = method.name;
  row.runs = outcomes.size();
  std::vector<ClusteredError> errors;
  double rotation_sum = 0.0, good = 0.0, sensors = 0.0, placed = 0.0;
  const bool bodies = method.kind == Method::Kind::bodies;
  for (std::size_t r = 0; r < outcomes.size(); ++r) {
    row.failed_runs += outcomes[r].failed;
    for (const PoseError& e : outcomes[r].sensors) {
      errors.push_back({r, e.position_m});
      sensors += 1.0;
      if (!std::isfinite(e.position_m)) continue;
      placed += 1.0;
      rotation_sum += e.rotation_rad;
      row.rotation_max_rad = std::fmax(row.rotation_max_rad, e.rotation_rad);
      good += e.position_m <= (bodies ? kGoodBodies_m : kGoodPosition_m) &&
              e.rotation_rad <= (bodies ? kGoodBodies_rad : kGoodRotation_rad);
    }
  }
  row.position = spread_of(errors);
  if (placed > 0.0) row.rotation_mean_rad = rotation_sum / placed;
  if (sensors > 0.0) row.within_limits_share = good / sensors;
  add_misfits(outcomes, row);
  return row;
}

std::string rig_item(std::size_t run) { return fmt::format("rigs/run-{}", run); }

// One run by every method.
std::vector<RunOutcome> measure_run(const CalibrationSpec& spec, const std::vector<RigidTransform>& truth,
                                    std::size_t number, const std::filesystem::path& scratch,
                                    const Watch& watch) {
  const SimulatedRun run = simulate_run(spec, truth, number, watch);
  std::vector<RunOutcome> outcomes;
  for (const Method& method : methods()) {
    watch.check();
    outcomes.push_back(method.kind == Method::Kind::two_positions ? run_two_positions(run, method, truth)
                       : method.kind == Method::Kind::wand        ? run_wand(spec, run, truth)
                       : spec.bodies_s > 0.0                      ? run_bodies(spec, number, truth, scratch)
                                                                  : RunOutcome{});
  }
  return outcomes;
}

std::vector<RunOutcome> read_run(const Outcome& outcome) {
  const Json json = outcome.json;
  std::vector<RunOutcome> outcomes = read_as<RunOutcomes>(JsonObject(json, outcome.place(), "")).methods;
  if (outcomes.size() != methods().size())
    throw InputError(outcome.place(), fmt::format("must have {} methods", methods().size()));
  return outcomes;
}

}  // namespace

std::vector<RigidTransform> true_rig(const CalibrationSpec& spec) {
  std::vector<RigidTransform> rig;
  for (const SensorPose& pose : rig_poses(spec.rig, {0.0, 1.0, 0.0})) rig.push_back(pose.world_from_sensor);
  return rig;
}

std::vector<Item> rig_items(const CalibrationSpec& spec) {
  constexpr double kBodies = 20.0;  // images that a second of walking costs
  const double cost = static_cast<double>(spec.positions * spec.position_frames * spec.rig.heights_m.size()) +
                      kBodies * spec.bodies_s;
  std::vector<Item> items;
  for (std::uint64_t r = 0; r < spec.runs; ++r)
    items.push_back({rig_item(r), cost, [spec, r](const std::filesystem::path& scratch, const Watch& watch) {
                       return json_of(RunOutcomes{measure_run(spec, true_rig(spec), r, scratch, watch)});
                     }});
  return items;
}

std::vector<RigRow> read_rigs(const CalibrationSpec& spec, const Outcomes& outcomes_by_id) {
  std::vector<RigRow> rows;
  if (spec.runs == 0) return rows;
  const std::vector<Method> all = methods();
  std::vector<std::vector<RunOutcome>> outcomes(all.size());
  for (std::uint64_t r = 0; r < spec.runs; ++r) {
    std::vector<RunOutcome> run = read_run(outcomes_by_id.at(rig_item(r)));
    for (std::size_t m = 0; m < all.size(); ++m) outcomes[m].push_back(std::move(run[m]));
  }
  for (std::size_t m = 0; m < all.size(); ++m)
    if (all[m].kind != Method::Kind::bodies || spec.bodies_s > 0.0)
      rows.push_back(row_of(all[m], outcomes[m]));
  return rows;
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
