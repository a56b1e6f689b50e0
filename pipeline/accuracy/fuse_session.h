// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/units.h"
#include "datasets/mocap/mocap_writer.h"
#include "datasets/results/summary.h"
#include "datasets/rig/calibration.h"
#include "pipeline/accuracy/methods/method_spec.h"
#include "pipeline/accuracy/tracking_summary.h"
#include "pipeline/study/run_control.h"

namespace trilat {

struct FusedPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNaN);
  double sigma_m = kNaN;  // an axis, of the method's own model
  SolveStatus status = SolveStatus::not_solved;
};

// Instants at which a sensor's left and right were found exchanged, and put right.
struct ExchangedStretch {
  std::string sensor;
  double first_s = 0.0, last_s = 0.0;  // since the first instant
};

struct FusedSession {
  double rate_hz = 30.0;
  std::int64_t start_host_ns = 0;  // of the first instant
  std::vector<Joint> joints;
  std::vector<FusedPoint> points;  // instants times joints; a position that no sensor gives is NaN
  std::vector<std::string> sensors;
  RayNoiseRow rays;
  std::vector<CheckRow> checks;
  std::vector<TakeNote> notes;
  std::vector<ExchangedStretch> exchanged;
  double answered = 0.0;  // share of instants and joints

  std::size_t instants() const { return joints.empty() ? 0 : points.size() / joints.size(); }
};

// One person of a session by one method, without any ground truth: the one whom its sensors see most. All
// joints, from the first to the last body frame of any sensor. InputError as a study's take; Interrupted when
// asked to stop.
FusedSession fuse_session(const std::filesystem::path& session, const std::filesystem::path& calibration,
                          const MethodSpec& method, double rate_hz, const RunControl& control);

// A calibration whose sensors are turned and shifted as the bodies of a session show, with the covariances
// that they leave; and what they show. Sensors that the session does not have stay as they are. InputError
// when they tell nothing, and as fuse_session().
struct CorrectedCalibration {
  Calibration calibration;
  std::vector<CheckRow> checks;  // of the poses
  std::vector<TakeNote> notes;
};
CorrectedCalibration correct_calibration(const std::filesystem::path& session,
                                         const std::filesystem::path& calibration, const RunControl& control);

// The joints as writers of marker files take them; refers to `fused`.
JointTrack track_of(const FusedSession& fused);

}  // namespace trilat
