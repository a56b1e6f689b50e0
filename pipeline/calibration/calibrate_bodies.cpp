// SPDX-License-Identifier: MIT
#include "pipeline/calibration/calibrate_bodies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "datasets/session/clock/session_clock.h"
#include "evaluators/calibration/rig_start.h"
#include "evaluators/ceres/rig_refinement.h"
#include "pipeline/accuracy/take/sensor_track.h"
#include "pipeline/calibration/wand_in_world.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

using Covariance = Eigen::Matrix<double, 6, 6>;

// A tracker that sees a back may take the left side for the right; these it cannot exchange.
constexpr std::array kMidline{Joint::spine_base, Joint::spine_mid, Joint::spine_shoulder, Joint::neck,
                              Joint::head};

constexpr std::size_t kMinJoints = 5;

struct Span {
  HostTime first, last;
};

// The time that all sensors cover.
Span common_span(const SessionReader& session, const std::vector<SensorClockMap>& host_from_sensor) {
  Span span{{std::numeric_limits<std::int64_t>::min()}, {std::numeric_limits<std::int64_t>::max()}};
  for (std::size_t s = 0; s < host_from_sensor.size(); ++s) {
    const std::uint64_t frames = session.counts(s).body_frames;
    const auto time = [&](std::uint64_t row) {
      return host_from_sensor[s](session.stamps(s, FrameStream::bodies, row, 1)[0]);
    };
    span.first = std::max(span.first, time(0));
    span.last = std::min(span.last, time(frames - 1));
  }
  if (!(span.first < span.last))
    throw InputError(session.path().string(), "has no time that all of its sensors cover");
  return span;
}

// Point number instant * kJointCount + joint.
RigProblem gather(const SessionReader& session, const CalibrateBodiesOptions& options,
                  std::vector<std::string>& notes) {
  const std::size_t sensors = session.header().sensors.size();
  std::vector<SensorClockMap> clocks;
  std::vector<SensorBodies> bodies;
  std::vector<double> backward_feet;
  for (std::size_t s = 0; s < sensors; ++s) {
    if (session.counts(s).body_frames == 0)
      throw InputError(session.path().string() + ":/sensors/" + session.header().sensors[s].name,
                       "has no body frames, from which the sensors could be placed");
    clocks.push_back(fit_sensor_clock(session, s));
    bodies.push_back(read_sensor_bodies(session, s, clocks.back(), options.stop_requested));
    const JointFaults& joints = bodies[s].joints;
    for (const auto& text : {joints.out_of_reach_text(), joints.misread_text(), joints.upside_down_text()})
      if (text) notes.push_back(session.header().sensors[s].name + ": " + *text);
    if (const auto share = joints.backward_feet()) backward_feet.push_back(*share);
  }
  if (const auto text = backward_feet_text(backward_feet)) notes.push_back("all sensors: " + *text);
  const Span span = common_span(session, clocks);
  RigProblem problem{sensors, options.instants * kJointCount, {}};
  std::vector<ObservedBody> seen(sensors);
  for (std::size_t i = 0; i < options.instants; ++i) {
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(options.instants);
    const HostTime t = span.first + duration_from_s(share * (span.last - span.first).seconds());
    for (std::size_t s = 0; s < sensors; ++s)
      seen[s] = body_at(bodies[s].frames, t, duration_from_s(options.longest_gap_s));
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const auto tracked = [&](std::size_t s) { return seen[s].state[j] == TrackingState::tracked; };
      std::size_t trackers = 0;
      for (std::size_t s = 0; s < sensors; ++s) trackers += tracked(s);
      if (trackers < 2) continue;
      for (std::size_t s = 0; s < sensors; ++s)
        if (tracked(s))
          problem.observations.push_back(
              {s, i * kJointCount + j, seen[s].at(static_cast<Joint>(j)),
               options.joint_sigma_m * options.joint_sigma_m * Eigen::Matrix3d::Identity()});
    }
  }
  return problem;
}

bool is_midline(std::size_t point) {
  return std::ranges::find(kMidline, static_cast<Joint>(point % kJointCount)) != kMidline.end();
}

RigProblem part_of(const RigProblem& problem, const std::function<bool(std::size_t)>& wanted_point) {
  RigProblem part{problem.sensors, problem.points, {}};
  for (const PointObservation& o : problem.observations)
    if (wanted_point(o.point)) part.observations.push_back(o);
  return part;
}

RigStart start_of(const RigProblem& problem) {
  const RigStartOptions options{.tolerance_m = 0.15, .least_breadth_m = 0.1};
  RigStart start = initial_poses(part_of(problem, is_midline), options);
  if (!start.complete()) start = initial_poses(problem, options);
  return start;
}

void check_placement(const RigStart& start, const SessionReader& session) {
  for (std::size_t s = 0; s < start.placement.size(); ++s) {
    const std::string who = "sensor \"" + session.header().sensors[s].name + "\" ";
    const std::string place = session.path().string();
    switch (start.placement[s]) {
      case SensorPlacement::placed:
        break;
      case SensorPlacement::nothing_seen:
        if (start.placement.size() == 1)
          throw InputError(place,
                           "has one sensor; poses need two or more that track a person at the same time");
        throw InputError(place, who + "tracks no person at a time when another sensor does");
      case SensorPlacement::no_common_view:
        throw InputError(
            place,
            who + "tracks the person together with no other sensor; let the person walk where two see them");
      case SensorPlacement::points_on_line:
        throw InputError(place, who + "is undetermined: the person hardly moves while two sensors see them");
      case SensorPlacement::disagrees:
        throw InputError(place, who +
                                    "tracks a person whom no pose brings together with the others'; is it "
                                    "the same person, and are the clocks right?");
    }
  }
}

// The reference sensor above the world's origin, its y axis along the floor's normal; nothing when it sees no
// floor or looks straight down, so that no direction is forward.
std::optional<RigidTransform> levelled(const SessionReader& session, std::size_t sensor) {
  const std::optional<FloorPlane> floor = floor_seen_by(session, sensor);
  if (!floor) return std::nullopt;
  const Eigen::Vector3d up = floor->up_in_sensor;
  const Eigen::Vector3d forward = Eigen::Vector3d::UnitZ() - up.z() * up;
  if (!(forward.norm() > 0.1)) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.row(1) = up.transpose();
  axes.row(2) = forward.normalized().transpose();
  axes.row(0) = axes.row(1).cross(axes.row(2));
  return RigidTransform{Eigen::Quaterniond(axes).normalized(), {0.0, floor->height_m, 0.0}};
}

// The refinement of one rig, and of problems that differ from its own in a few observations.
class BodyRefinement {
 public:
  BodyRefinement(const RigProblem& problem, const RigStart& start, const RigidTransform& world_from_reference,
                 double robust_scale)
      : reference_(start.reference) {
    gauge_.world_from_reference = world_from_reference;
    options_.robust_scale = robust_scale;
    options_.rejection_rounds = 0;
    options_.covariances = false;
    solution_ = bundle_adjust(problem, start.reference_from_sensor, reference_, gauge_, options_);
  }
  const RigRefinement& solution() const { return solution_; }

  // How the poses of the other problem differ from the solution's: of each sensor the rotation vector in
  // world axes and the position (rad, m), six rows a sensor. Nothing where it has no solution.
  std::optional<Eigen::VectorXd> difference(const RigProblem& other) const {
    const RigidTransform reference_from_world = solution_.sensors[reference_].world_from_sensor.inverse();
    std::vector<RigidTransform> start;
    for (const RefinedSensor& sensor : solution_.sensors)
      start.push_back(reference_from_world * sensor.world_from_sensor);
    const RigRefinement refined = bundle_adjust(other, start, reference_, gauge_, options_);
    if (refined.status != RigStatus::converged) return std::nullopt;
    Eigen::VectorXd rows(6 * static_cast<Eigen::Index>(start.size()));
    for (std::size_t s = 0; s < start.size(); ++s) {
      const RigidTransform &to = refined.sensors[s].world_from_sensor,
                           &from = solution_.sensors[s].world_from_sensor;
      const Eigen::AngleAxisd turn(to.rotation * from.rotation.conjugate());
      rows.segment<6>(6 * static_cast<Eigen::Index>(s)) << turn.angle() * turn.axis(),
          to.translation_m - from.translation_m;
    }
    return rows;
  }

 private:
  std::size_t reference_;
  RigGauge gauge_;
  RigRefinementOptions options_;
  RigRefinement solution_;
};

// The observations as they would be if one sensor measured all depths too far by `error_m`.
RigProblem with_depth_error(RigProblem problem, std::size_t sensor, double error_m) {
  for (PointObservation& o : problem.observations)
    if (o.sensor == sensor) o.point_in_sensor_m *= 1.0 + error_m / o.point_in_sensor_m.z();
  return problem;
}

// Covariances of the poses by a jackknife over joints, each left out in turn, and by the depth error of each
// unit, which all its joints share. InputError where the poses do not follow from the joints that are left.
std::vector<Covariance> covariances_of(const RigProblem& problem, const BodyRefinement& refinement,
                                       const CalibrateBodiesOptions& options, const std::string& place) {
  std::set<std::size_t> seen;
  for (const PointObservation& o : problem.observations) seen.insert(o.point % kJointCount);
  const std::vector<std::size_t> joints(seen.begin(), seen.end());
  const auto rows = static_cast<Eigen::Index>(6 * problem.sensors);
  Eigen::MatrixXd without_joint(rows, static_cast<Eigen::Index>(joints.size()));
  Eigen::MatrixXd by_depth(rows, static_cast<Eigen::Index>(problem.sensors));
  const auto changed = [&](std::size_t k) {  // joints first, then sensors
    return k < joints.size()
               ? part_of(problem, [&](std::size_t point) { return point % kJointCount != joints[k]; })
               : with_depth_error(problem, k - joints.size(), options.unit_depth_sigma_m);
  };
  std::vector<std::optional<Eigen::VectorXd>> differences(joints.size() + problem.sensors);
  parallel_for_index(differences.size(), 1, [&](std::size_t k) {
    if (options.stop_requested && options.stop_requested()) return;
    const RigProblem other = changed(k);
    if (start_of(other).complete()) differences[k] = refinement.difference(other);
  });
  if (options.stop_requested && options.stop_requested()) throw Interrupted();
  const auto is_known = [](const std::optional<Eigen::VectorXd>& difference) {
    return difference.has_value();
  };
  if (joints.size() < kMinJoints || !std::ranges::all_of(differences, is_known))
    throw InputError(
        place,
        fmt::format(
            "shows too few joints to say how sure the poses are: {} that two sensors track at the same time",
            joints.size()));
  for (Eigen::Index k = 0; k < without_joint.cols(); ++k)
    without_joint.col(k) = *differences[static_cast<std::size_t>(k)];
  for (Eigen::Index s = 0; s < by_depth.cols(); ++s)
    by_depth.col(s) = *differences[joints.size() + static_cast<std::size_t>(s)];
  const auto n = static_cast<double>(joints.size());
  const Eigen::MatrixXd about_mean = without_joint.colwise() - without_joint.rowwise().mean();
  std::vector<Covariance> result;
  for (std::size_t s = 0; s < problem.sensors; ++s) {
    const auto at = static_cast<Eigen::Index>(6 * s);
    const Eigen::MatrixXd by_joints = about_mean.middleRows<6>(at), of_sensor = by_depth.middleRows<6>(at);
    result.emplace_back((n - 1.0) / n * by_joints * by_joints.transpose() +
                        of_sensor * of_sensor.transpose());
  }
  return result;
}

}  // namespace

BodyCalibration calibrate_bodies(const std::filesystem::path& path, const CalibrateBodiesOptions& options) {
  const WatchedFiles watched({path});
  const SessionReader session(path);
  BodyCalibration result;
  const RigProblem problem = gather(session, options, result.notes);
  const RigStart start = start_of(problem);
  check_placement(start, session);
  const std::optional<RigidTransform> level = levelled(session, start.reference);
  const BodyRefinement refinement(problem, start, level.value_or(RigidTransform{}), options.robust_scale);
  const RigRefinement& refined = refinement.solution();
  if (refined.status != RigStatus::converged)
    throw InputError(path.string(),
                     "cannot be calibrated: the refinement ended with " + name_of(refined.status));
  const auto covariances = covariances_of(problem, refinement, options, path.string());
  result.reference = start.reference;
  Calibration& calibration = result.calibration;
  calibration.method = "bodies";
  calibration.simulated = session.header().simulated;
  calibration.world =
      "sensor " + session.header().sensors[start.reference].name + (level ? ", on the floor below it" : "");
  calibration.program = kProgramVersion;
  if (std::isfinite(refined.reduced_chi2)) calibration.reduced_chi2 = refined.reduced_chi2;
  std::set<std::size_t> points;
  for (const PointObservation& o : problem.observations) points.insert(o.point);
  calibration.positions = points.size();
  for (std::size_t s = 0; s < problem.sensors; ++s) {
    SensorPose pose;
    pose.name = session.header().sensors[s].name;
    pose.world_from_sensor = refined.sensors[s].world_from_sensor;
    pose.covariance = covariances[s];
    pose.rotation_sigma_rad = std::sqrt(covariances[s].topLeftCorner<3, 3>().trace() / 3.0);
    pose.position_sigma_m = std::sqrt(covariances[s].bottomRightCorner<3, 3>().trace() / 3.0);
    pose.residual_rms_m = refined.sensors[s].rms_m;
    pose.used = refined.sensors[s].used;
    calibration.sensors.push_back(pose);
  }
  calibration.sources = {{path.filename().string(), hash_of_file(path, options.stop_requested)}};
  watched.check();
  return result;
}

}  // namespace trilat
