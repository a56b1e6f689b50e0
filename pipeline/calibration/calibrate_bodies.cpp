// SPDX-License-Identifier: MIT
#include "pipeline/calibration/calibrate_bodies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <span>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/version.h"
#include "datasets/session/clock/session_clock.h"
#include "evaluators/calibration/rig_start.h"
#include "evaluators/ceres/rig_refinement.h"
#include "pipeline/accuracy/take/sensor_track.h"
#include "pipeline/calibration/wand_in_world.h"
#include "pipeline/study/hash_cache.h"

namespace trilat {
namespace {

using Covariance = Eigen::Matrix<double, 6, 6>;

// A tracker that sees a back may take the left side for the right; these it cannot exchange.
constexpr std::array kMidline{Joint::spine_base, Joint::spine_mid, Joint::spine_shoulder, Joint::neck,
                              Joint::head};

constexpr std::size_t kFewestJoints = 5;

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
  for (std::size_t s = 0; s < sensors; ++s) {
    if (session.counts(s).body_frames == 0)
      throw InputError(session.path().string() + ":/sensors/" + session.header().sensors[s].name,
                       "has no body frames, from which the sensors could be placed");
    clocks.push_back(fit_sensor_clock(session, s));
    bodies.push_back(read_sensor_bodies(session, s, clocks.back(), options.stop_requested));
    if (const auto text = out_of_reach_text(bodies[s].out_of_reach))
      notes.push_back(session.header().sensors[s].name + ": " + *text);
  }
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

double square(double value) { return value * value; }

// The normal equations of all sensors' turns (rotation vector in world axes) and positions but the
// reference's, without the points, each of which stands in no other's equations: one Newton step of the
// robust loss.
struct Equations {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd of_depth;  // by sensor: how its gradient changes when its unit measures too far
};

// Adds what one point's observations say. Their loss is soft-L1: rho(x) = 2 a^2 (sqrt(1 + x / a^2) - 1) of
// the squared distance in standard deviations.
void add_point(std::span<const PointObservation> seen, const Eigen::Vector3d& point_in_world_m,
               const RigRefinement& solution, std::size_t reference, const CalibrateBodiesOptions& options,
               Equations& equations) {
  const double per_m2 = 1.0 / (options.joint_sigma_m * options.joint_sigma_m);
  const Eigen::Index unknowns = equations.gradient.size();
  Eigen::Matrix3d of_point = Eigen::Matrix3d::Zero();
  Eigen::MatrixXd mixed = Eigen::MatrixXd::Zero(3, unknowns);
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();
  Eigen::MatrixXd pull_of_depth = Eigen::MatrixXd::Zero(3, equations.of_depth.cols());
  for (const PointObservation& o : seen) {
    const RigidTransform& pose = solution.sensors[o.sensor].world_from_sensor;
    const Eigen::Vector3d turned_m = pose.rotation * o.point_in_sensor_m;
    const Eigen::Vector3d off_m = point_in_world_m - turned_m - pose.translation_m;
    const double root = std::sqrt(1.0 + off_m.squaredNorm() * per_m2 / square(options.robust_scale));
    const Eigen::Matrix3d weight = per_m2 / root *
                                   (Eigen::Matrix3d::Identity() -
                                    per_m2 / square(options.robust_scale * root) * off_m * off_m.transpose());
    const Eigen::Vector3d force = per_m2 / root * off_m;
    // a unit's depth error moves a joint along its ray
    const Eigen::Vector3d force_of_depth =
        -options.unit_depth_sigma_m / o.point_in_sensor_m.z() * (weight * turned_m);
    of_point += weight;
    pull += force;
    pull_of_depth.col(static_cast<Eigen::Index>(o.sensor)) += force_of_depth;
    if (o.sensor == reference) continue;
    const Eigen::Index at = 6 * static_cast<Eigen::Index>(o.sensor - (o.sensor > reference ? 1 : 0));
    Eigen::Matrix<double, 3, 6> by_pose;
    by_pose << 0.0, -turned_m.z(), turned_m.y(), -1.0, 0.0, 0.0, turned_m.z(), 0.0, -turned_m.x(), 0.0, -1.0,
        0.0, -turned_m.y(), turned_m.x(), 0.0, 0.0, 0.0, -1.0;
    equations.information.block<6, 6>(at, at) += by_pose.transpose() * weight * by_pose;
    equations.gradient.segment<6>(at) += by_pose.transpose() * force;
    equations.of_depth.col(static_cast<Eigen::Index>(o.sensor)).segment<6>(at) +=
        by_pose.transpose() * force_of_depth;
    mixed.middleCols<6>(at) += weight * by_pose;
  }
  const Eigen::MatrixXd eliminated = of_point.ldlt().solve(mixed);
  equations.information -= mixed.transpose() * eliminated;
  equations.gradient -= eliminated.transpose() * pull;
  equations.of_depth -= eliminated.transpose() * pull_of_depth;
}

// Covariances of the poses by a jackknife over joints: from the solution one Newton step with each left out;
// and by the depth error of each unit, which all its joints share.
std::vector<Covariance> covariances_of(const RigProblem& problem, const RigRefinement& solution,
                                       std::size_t reference, const CalibrateBodiesOptions& options,
                                       const std::string& place) {
  const auto unknowns = static_cast<Eigen::Index>(6 * (problem.sensors - 1));
  const Equations none{Eigen::MatrixXd::Zero(unknowns, unknowns), Eigen::VectorXd::Zero(unknowns),
                       Eigen::MatrixXd::Zero(unknowns, static_cast<Eigen::Index>(problem.sensors))};
  std::map<std::size_t, Equations> of_joint;
  const std::span<const PointObservation> all(problem.observations);
  for (std::size_t first = 0, last = 0; first < all.size(); first = last) {  // a point's are neighbours
    const std::size_t point = all[first].point;
    while (last < all.size() && all[last].point == point) ++last;
    add_point(all.subspan(first, last - first), solution.point_in_world_m[point], solution, reference,
              options, of_joint.try_emplace(point % kJointCount, none).first->second);
  }
  Equations sum = none;
  for (const auto& [joint, equations] : of_joint) {
    sum.information += equations.information;
    sum.gradient += equations.gradient;
    sum.of_depth += equations.of_depth;
  }
  Eigen::MatrixXd steps(unknowns, static_cast<Eigen::Index>(of_joint.size()));
  Eigen::Index column = 0;
  bool known = of_joint.size() >= kFewestJoints;
  for (const auto& [joint, equations] : of_joint) {
    const Eigen::LDLT<Eigen::MatrixXd> rest(sum.information - equations.information);
    known = known && rest.isPositive() && rest.rcond() > 1e-12;
    if (known) steps.col(column++) = rest.solve(equations.gradient - sum.gradient);
  }
  if (!known)
    throw InputError(
        place,
        fmt::format(
            "shows too few joints to say how sure the poses are: {} that two sensors track at the same time",
            of_joint.size()));
  const double n = static_cast<double>(steps.cols());
  const Eigen::MatrixXd about_mean = steps.colwise() - steps.rowwise().mean();
  const Eigen::MatrixXd by_depth = sum.information.ldlt().solve(sum.of_depth);
  std::vector<Covariance> result(problem.sensors, Covariance::Zero());
  for (std::size_t s = 0; s < problem.sensors; ++s) {
    if (s == reference) continue;
    const Eigen::Index at = 6 * static_cast<Eigen::Index>(s - (s > reference ? 1 : 0));
    const auto by_joints = about_mean.middleRows<6>(at), of_sensor = by_depth.middleRows<6>(at);
    result[s] = (n - 1.0) / n * by_joints * by_joints.transpose() + of_sensor * of_sensor.transpose();
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
  RigGauge gauge;
  const std::optional<RigidTransform> level = levelled(session, start.reference);
  gauge.world_from_reference = level.value_or(RigidTransform{});
  RigRefinementOptions refinement;
  refinement.robust_scale = options.robust_scale;
  refinement.rejection_rounds = 0;
  refinement.covariances = false;
  const RigRefinement refined =
      bundle_adjust(problem, start.reference_from_sensor, start.reference, gauge, refinement);
  if (refined.status != RigStatus::converged)
    throw InputError(path.string(),
                     "cannot be calibrated: the refinement ended with " + name_of(refined.status));
  const auto covariances = covariances_of(problem, refined, start.reference, options, path.string());
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
