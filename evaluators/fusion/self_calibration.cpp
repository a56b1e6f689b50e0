// SPDX-License-Identifier: MIT
#include "evaluators/fusion/self_calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "datasets/base/error.h"
#include "evaluators/fusion/ray_variances.h"
#include "evaluators/metrics/statistics.h"
#include "evaluators/solvers/descent.h"

namespace trilat {
namespace {

constexpr int kParameters = 7;  // of a sensor
constexpr std::size_t kMinRows = 20;
constexpr int kMinRounds = 8, kMaxRounds = 40, kRobustPasses = 3;
constexpr double kSettled = 0.1;      // standard deviations
constexpr int kFirstOfPriors = 2;     // round from which the priors are estimated
constexpr double kStatedCount = 8.0;  // parameters of sensors that the stated priors count as
constexpr double kLossScale = 3.0;    // sigmas
constexpr double kVarianceTolerance = 1e-4;
constexpr double kNormalQuantile = 1.959964;  // of 95 %
constexpr double kMinPrior = 1e-4;            // rad or m

Eigen::Quaterniond inverse_rotation(const Eigen::Vector3d& rotation_rad) {
  const double angle_rad = rotation_rad.norm();
  if (angle_rad == 0.0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(-angle_rad, rotation_rad / angle_rad));
}

class Calibrator {
 public:
  Calibrator(std::span<const JointObservation> observations, std::span<const RigidTransform> rig,
             std::span<const std::uint32_t> joint, const PosePriors& priors)
      : rig_(rig),
        stated_priors_(priors),
        priors_(priors),
        rows_(ray_rows(observations, rig.size(), joint)),
        theta_(Eigen::VectorXd::Zero(size())) {
    for (const RayViews& row : rows_.rows) {
      joints_.try_emplace(row.cluster, joints_.size());
      for (const RayView& view : row.views) stated_m_.push_back(view.point_m);
    }
  }

  std::size_t rows() const { return rows_.rows.size(); }
  std::size_t joints() const { return joints_.size(); }

  SelfCalibration run() {
    double moved = std::numeric_limits<double>::infinity();
    for (int round = 0; round < kMaxRounds && (round < kMinRounds || !(moved <= kSettled)); ++round) {
      correct();
      converge(rows_, poses_, kVarianceTolerance, round == 0 ? 25 : 8, sigma_);
      place_robustly();
      moved = step(round);
    }
    if (!(moved <= kSettled)) {
      SelfCalibration unsettled;
      unsettled.problem = "the corrections still move after " + std::to_string(kMaxRounds) + " rounds";
      return unsettled;
    }
    // With few sensors an estimated prior is uncertain: the covariance counts the stated one as more
    // parameters.
    covariance_ = (information_ + precision_of(estimated_priors(kStatedCount))).inverse();
    return result();
  }

 private:
  Eigen::Index size() const { return kParameters * static_cast<Eigen::Index>(rig_.size()); }

  PoseCorrection correction_of(std::size_t s) const {
    const auto of = theta_.segment<kParameters>(kParameters * static_cast<Eigen::Index>(s));
    PoseCorrection correction;
    correction.rotation_rad = of.head<3>();
    correction.translation_m = of.segment<3>(3);
    correction.range_m = of[6];
    return correction;
  }

  void correct() {
    poses_.clear();
    std::vector<Eigen::Matrix3d> back;
    for (std::size_t s = 0; s < rig_.size(); ++s) {
      const PoseCorrection c = correction_of(s);
      back.push_back(inverse_rotation(c.rotation_rad).toRotationMatrix());
      poses_.push_back(corrected_pose(rig_[s], c));
    }
    auto stated_m = stated_m_.begin();
    for (RayViews& row : rows_.rows)
      for (RayView& view : row.views) {
        const Eigen::Vector3d v = back[view.sensor] * (*stated_m++ - rig_[view.sensor].translation_m);
        const double offset_m = theta_[kParameters * static_cast<Eigen::Index>(view.sensor) + 6];
        view.point_m = poses_[view.sensor].translation_m + v * (1.0 - offset_m / v.norm());
      }
  }

  // Places by M-estimates; the weights stay with the views. The curvature of Cauchy's loss is less than they
  // say.
  void place_robustly() {
    double curvature = 0.0, weights = 0.0;
    for (RayViews& row : rows_.rows) {
      place(row, poses_, sigma_);
      std::array<Eigen::Matrix3d, kMaxSensors> full;
      for (std::size_t k = 0; k < row.views.size(); ++k) full[k] = row.views[k].weight;
      for (int pass = 0; pass < kRobustPasses; ++pass) {
        Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
        Eigen::Vector3d right = Eigen::Vector3d::Zero();
        for (std::size_t k = 0; k < row.views.size(); ++k) {
          RayView& view = row.views[k];
          const Eigen::Vector3d e = view.linearised_point_m - row.position_m;
          view.weight = full[k] / (1.0 + e.dot(full[k] * e) / (kLossScale * kLossScale));
          information += view.weight;
          right += view.weight * view.linearised_point_m;
        }
        row.covariance = information.inverse();
        row.position_m = row.covariance * right;
      }
      for (std::size_t k = 0; k < row.views.size(); ++k) {
        const Eigen::Vector3d e = row.views[k].linearised_point_m - row.position_m;
        const double square = e.dot(full[k] * e) / (kLossScale * kLossScale), weight = 1.0 / (1.0 + square);
        weights += 3.0 * weight;
        curvature += 3.0 * weight - 2.0 * weight * weight * square;
      }
    }
    curvature_ = curvature / weights;
  }

  // How the view's corrected point moves with its sensor's turn, shift and range offset.
  Eigen::Matrix<double, 3, kParameters> design(const RayView& view) const {
    const Eigen::Vector3d v = view.point_m - poses_[view.sensor].translation_m;
    Eigen::Matrix<double, 3, kParameters> design;
    design.leftCols<3>() << 0.0, v.z(), -v.y(), -v.z(), 0.0, v.x(), v.y(), -v.x(), 0.0;
    design.middleCols<3>(3).setIdentity();
    design.col(6) = v.normalized();
    return design;
  }

  // The largest change of a parameter, in its standard deviations.
  double step(int round) {
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size(), size());
    Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(joints_.size()), size());
    for (const RayViews& row : rows_.rows) add(row, information, scores);
    information.triangularView<Eigen::StrictlyUpper>() = information.transpose();
    design_effect_ = design_effect(information, scores, round == 0);
    information_ = information * curvature_ * curvature_ / design_effect_;
    const Eigen::MatrixXd precision = precision_of(priors_);
    const Eigen::VectorXd right =
        scores.colwise().sum().transpose() * curvature_ / design_effect_ - precision * theta_;
    covariance_ = (information_ + precision).inverse();
    const Eigen::VectorXd change = covariance_ * right;
    theta_ += change;
    if (round >= kFirstOfPriors) priors_ = only_narrower(estimated_priors(0.0));
    return (change.array().abs() / covariance_.diagonal().array().sqrt()).maxCoeff();
  }

  // The row's part of the normal equations, its place eliminated.
  void add(const RayViews& row, Eigen::MatrixXd& information, Eigen::MatrixXd& scores) const {
    const auto joint = static_cast<Eigen::Index>(joints_.at(row.cluster));
    std::array<Eigen::Matrix<double, 3, kParameters>, kMaxSensors> weighted, placed;
    for (std::size_t k = 0; k < row.views.size(); ++k) {
      const RayView& view = row.views[k];
      const Eigen::Matrix<double, 3, kParameters> of = design(view);
      weighted[k] = view.weight * of;
      placed[k] = row.covariance * weighted[k];
      const Eigen::Index at = kParameters * static_cast<Eigen::Index>(view.sensor);
      information.block<kParameters, kParameters>(at, at) += of.transpose() * weighted[k];
      scores.row(joint).segment<kParameters>(at) +=
          (weighted[k].transpose() * (view.linearised_point_m - row.position_m)).transpose();
    }
    for (std::size_t a = 0; a < row.views.size(); ++a)
      for (std::size_t b = 0; b <= a; ++b)  // the lower half: sensors rise
        information.block<kParameters, kParameters>(
            kParameters * static_cast<Eigen::Index>(row.views[a].sensor),
            kParameters * static_cast<Eigen::Index>(row.views[b].sensor)) -=
            weighted[a].transpose() * placed[b];
  }

  // How much more the joints' scores vary than those of independent views, in the directions that the views
  // tell at all.
  double design_effect(const Eigen::MatrixXd& information, const Eigen::MatrixXd& scores,
                       bool centred) const {
    constexpr double kTold = 1e-3;  // of the best told direction
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
    const double least = kTold * eigen.eigenvalues().maxCoeff();
    double squares = 0.0, directions = 0.0;
    for (Eigen::Index k = 0; k < size(); ++k) {
      if (eigen.eigenvalues()[k] <= least) continue;
      Eigen::VectorXd z = scores * eigen.eigenvectors().col(k) / std::sqrt(eigen.eigenvalues()[k]);
      if (centred) z.array() -= z.mean();
      squares += z.squaredNorm();
      directions += 1.0;
    }
    // constants of joints in sensors' views, less where the joints are and what was told
    const double constants = 3.0 * static_cast<double>(joints_.size() * (rig_.size() - 1));
    return std::max(1.0, squares / directions * constants / std::max(1.0, constants - directions));
  }

  using KindArray = Eigen::Array<double, kParameters, 1>;  // a number for each parameter of a sensor
  static KindArray squared(const PosePriors& p) {
    KindArray sigma;
    sigma << p.rotation_rad, p.rotation_rad, p.rotation_rad, p.translation_m, p.translation_m,
        p.translation_m, p.range_m;
    return sigma.square();
  }

  // Prior precision: sensors' deviations from the rig's mean have `priors`, the mean the stated ones.
  Eigen::MatrixXd precision_of(const PosePriors& priors) const {
    const auto sensors = static_cast<double>(rig_.size());
    const KindArray own = squared(priors), common = squared(stated_priors_);
    const KindArray shared = common / (own * (own + sensors * common));
    Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(size(), size());
    for (Eigen::Index a = 0; a < size(); ++a) {
      precision(a, a) = 1.0 / own[a % kParameters];
      for (Eigen::Index b = a % kParameters; b < size(); b += kParameters)
        precision(a, b) -= shared[a % kParameters];
    }
    return precision;
  }

  // One step of expectation and maximisation on the sensors' deviations from their mean, in which the stated
  // priors count as so many parameters.
  PosePriors estimated_priors(double stated_count) const {
    const auto sensors = static_cast<Eigen::Index>(rig_.size());
    KindArray squares = KindArray::Zero();
    for (Eigen::Index k = 0; k < kParameters; ++k) {
      const auto of = Eigen::seqN(k, sensors, kParameters);
      const Eigen::VectorXd theta = theta_(of);
      const Eigen::MatrixXd covariance = covariance_(of, of);
      squares[k] = (theta.array() - theta.mean()).square().sum() + covariance.trace() -
                   covariance.sum() / static_cast<double>(sensors);
    }
    const auto sigma = [&](double stated, Eigen::Index first, Eigen::Index count) {
      const double freedom = static_cast<double>(count * (sensors - 1));
      return std::max(kMinPrior,
                      std::sqrt((stated_count * stated * stated + squares.segment(first, count).sum()) /
                                (stated_count + freedom)));
    };
    return {sigma(stated_priors_.rotation_rad, 0, 3), sigma(stated_priors_.translation_m, 3, 3),
            sigma(stated_priors_.range_m, 6, 1)};
  }
  PosePriors only_narrower(const PosePriors& estimated) const {
    return {estimated.rotation_rad, std::min(stated_priors_.translation_m, estimated.translation_m),
            std::min(stated_priors_.range_m, estimated.range_m)};
  }

  SelfCalibration result() const {
    SelfCalibration result;
    for (std::size_t s = 0; s < rig_.size(); ++s) {
      const Eigen::Index at = kParameters * static_cast<Eigen::Index>(s);
      result.of_sensor.push_back(correction_of(s));
      result.of_sensor.back().residual_rms_m = 0.0;
      result.of_sensor.back().covariance = covariance_.block<kParameters, kParameters>(at, at);
    }
    for (const RayViews& row : rows_.rows)
      for (const RayView& view : row.views) {
        PoseCorrection& of = result.of_sensor[view.sensor];
        ++of.views;
        of.residual_rms_m += (view.linearised_point_m - row.position_m).squaredNorm() / 3.0;
      }
    for (PoseCorrection& of : result.of_sensor)
      of.residual_rms_m = std::sqrt(of.residual_rms_m / static_cast<double>(of.views));
    return result;
  }

  std::span<const RigidTransform> rig_;
  PosePriors stated_priors_, priors_;
  RayRows rows_;                                 // their clusters are joints, and their points corrected
  std::vector<Eigen::Vector3d> stated_m_;        // the points of all views as the calibration has them
  std::map<std::uint32_t, std::size_t> joints_;  // their numbers
  std::vector<RigidTransform> poses_;            // corrected
  RaySigma sigma_{0.05, 0.05, 3.0};
  Eigen::VectorXd theta_;
  Eigen::MatrixXd information_, covariance_;
  double curvature_ = 1.0;  // of the loss, over the weights
  double design_effect_ = 1.0;
};

// Median and 95 % interval of a normal vector's length: the squared length is taken as gamma distributed with
// the mean and variance that it has; from 0 where the vector may be none, NaN where nothing is known of it.
Interval length_of(const Eigen::Vector3d& mean, const Eigen::Matrix3d& covariance) {
  const double square = mean.squaredNorm() + covariance.trace();
  const double variance = 2.0 * (covariance * covariance).trace() + 4.0 * mean.dot(covariance * mean);
  if (variance == 0.0) return {std::sqrt(square), std::sqrt(square), std::sqrt(square)};
  const double shape = square * square / variance, scale = variance / square;
  if (!(shape > 0.0 && scale > 0.0 && std::isfinite(shape) && std::isfinite(scale)))
    return {kNaN, kNaN, kNaN};
  constexpr double kChiSquare3 = 7.814727903251179;  // not exceeded in 95 %, three degrees of freedom
  const auto quantile = [&](double p) { return std::sqrt(gamma_quantile(p, shape, scale)); };
  const bool may_be_none = mean.dot(covariance.inverse() * mean) < kChiSquare3;
  return {quantile(0.5), may_be_none ? 0.0 : quantile(0.025), quantile(0.975)};
}

}  // namespace

RigidTransform corrected_pose(const RigidTransform& world_from_sensor, const PoseCorrection& correction) {
  return {(inverse_rotation(correction.rotation_rad) * world_from_sensor.rotation).normalized(),
          world_from_sensor.translation_m - correction.translation_m};
}

JointObservation corrected_view(const JointObservation& observation, const RigidTransform& world_from_sensor,
                                const PoseCorrection& correction) {
  JointObservation result = observation;
  if (!observation.seen || !(observation.range_m > kOnSensor_m)) return result;
  const Eigen::Vector3d v = inverse_rotation(correction.rotation_rad) *
                            (observation.point_in_world_m - world_from_sensor.translation_m);
  result.range_m = observation.range_m - correction.range_m;
  result.point_in_world_m =
      world_from_sensor.translation_m - correction.translation_m + v * (result.range_m / observation.range_m);
  return result;
}

CorrectionMagnitudes magnitudes_of(const SelfCalibration& calibration, std::size_t sensor) {
  if (!calibration.problem.empty()) return {};
  const PoseCorrection& c = calibration.of_sensor[sensor];
  const double quantile = student_quantile(calibration.joints - 1);
  const Eigen::Matrix<double, 7, 7> covariance = c.covariance * std::pow(quantile / kNormalQuantile, 2);
  const double reach_m = kNormalQuantile * std::sqrt(covariance(6, 6));
  return {length_of(c.rotation_rad, covariance.topLeftCorner<3, 3>()),
          length_of(c.translation_m, covariance.block<3, 3>(3, 3)),
          {c.range_m, c.range_m - reach_m, c.range_m + reach_m}};
}

SelfCalibration self_calibrate(std::span<const JointObservation> observations,
                               std::span<const RigidTransform> world_from_sensor,
                               std::span<const std::uint32_t> joint, const PosePriors& priors) {
  TRILAT_CHECK(observations.size() == world_from_sensor.size() * joint.size() &&
                   world_from_sensor.size() <= kMaxSensors,
               "every row has an observation of every sensor");
  TRILAT_CHECK(priors.rotation_rad > 0.0 && priors.translation_m > 0.0 && priors.range_m > 0.0,
               "priors are greater than 0");
  Calibrator calibrator(observations, world_from_sensor, joint, priors);
  SelfCalibration result;
  if (calibrator.rows() < kMinRows)
    result.problem = "fewer than " + std::to_string(kMinRows) + " times do two sensors see the same joint";
  else if (calibrator.joints() < 3)
    result.problem = "fewer than 3 joints are seen by two sensors";
  else
    result = calibrator.run();
  if (!result.problem.empty()) result.of_sensor.assign(world_from_sensor.size(), {});
  result.rows = calibrator.rows();
  result.joints = calibrator.joints();
  return result;
}

}  // namespace trilat
