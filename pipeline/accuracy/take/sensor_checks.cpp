// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "evaluators/alignment/alignment.h"
#include "evaluators/metrics/quantiles.h"
#include "evaluators/metrics/student.h"
#include "pipeline/accuracy/take/movement_lag.h"
#include "pipeline/accuracy/take/take_checks.h"

namespace trilat {
namespace {

constexpr std::size_t kMostViewInstants = 400;    // that places are compared at, spread over the take
constexpr std::size_t kMostClockInstants = 3000;  // that movements are compared at, one after the other
constexpr std::size_t kClockJoints = 6;
constexpr std::size_t kFewestRows = 100;  // joints at instants; fewer are not checked
// Beyond these the recording contradicts its description. Trackers differ by a few centimetres, and a
// calibration with bodies is good to a degree or two.
constexpr double kSameStream_m = 0.0003;  // a tracker's noise alone is 1 mm
constexpr double kMirrored_m = 0.1, kMirroredShare = 0.5;
constexpr double kApart_m = 0.3,
                 kLeastShare = 0.4;  // exchanged back, at most this share of the distances is left
constexpr double kMoved_m = 0.15;
constexpr double kMovement_s = 0.1;  // to both sides
constexpr double kClock_s = 0.1, kClockSigmas = 2.0;
constexpr double kClockSurely_s = 0.05;  // a lag less its uncertainty is larger
constexpr double kOneRange = 0.08, kAllRanges = 0.04;
constexpr double kSigmas = 3.0;         // and so many standard deviations over the sensors
constexpr double kLeastCrossing = 0.3;  // of the rays at a joint: 0 when all are parallel

using Points = std::vector<Eigen::Vector3d>;

double median_of(const std::vector<double>& values) { return quantiles_of(values, {0.5})[0]; }
// Standard deviation of two or more values, about their median.
double spread_of(const std::vector<double>& values, double median) {
  double squares = 0.0;
  for (const double value : values) squares += (value - median) * (value - median);
  return std::sqrt(squares / (static_cast<double>(values.size()) - 1.0));
}

const Eigen::Vector3d& no_point() {
  static const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  return none;
}

class SensorChecker {
 public:
  SensorChecker(const Plan& plan, const PlannedTake& planned, const BodyTracks& bodies)
      : plan_(plan), planned_(planned), bodies_(bodies), sensors_(bodies.sensors()) {
    for (const Joint joint : plan.joints)
      if (joint <= mirror_of(joint) || std::ranges::find(plan.joints, mirror_of(joint)) == plan.joints.end())
        joints_.push_back(joint);
    const std::size_t step = std::max<std::size_t>(1, bodies.instants() / kMostViewInstants);
    in_sensor_.resize(sensors_);
    for (std::size_t i = 0; i < bodies.instants(); i += step)
      for (const Joint joint : joints_)
        for (std::size_t s = 0; s < sensors_; ++s) in_sensor_[s].push_back(middle(i, s, joint));
    for (std::size_t s = 0; s < sensors_; ++s) sound_.push_back(s);
  }

  // The first finding explains those that would follow: sensors that are named are left out from then on.
  SensorChecks run() {
    find_same_streams();
    find_mirrored();
    place_all();
    if (find_exchanged_poses()) {
      checks_.misplaced = true;
    } else {
      find_clocks();  // a sensor that is late sees the person elsewhere: before the poses
      find_poses();
      find_moved();
      find_scales();
    }
    return std::move(checks_);
  }

 private:
  // The middle of a joint and that of the other side, in the sensor's frame: trackers take a person who turns
  // their back for one who faces them, which exchanges both.
  Eigen::Vector3d middle(std::size_t instant, std::size_t sensor, Joint joint) const {
    const ObservedBody& body = bodies_.at(instant, sensor);
    for (const Joint side : {joint, mirror_of(joint)})
      if (body.state[static_cast<std::size_t>(side)] != TrackingState::tracked) return no_point();
    return 0.5 * (body.at(joint) + body.at(mirror_of(joint)));
  }
  const std::string& name(std::size_t s) const { return plan_.rig[s]; }
  void leave_out(std::size_t s) { std::erase(sound_, s); }
  CheckRow row(std::size_t s, const char* what, const char* unit, double value, double limit) const {
    return {.take = planned_.take.id,
            .subject = name(s),
            .what = what,
            .unit = unit,
            .value = value,
            .limit = limit};
  }
  void add(const CheckRow& row, bool beyond) {
    checks_.rows.push_back(row);
    checks_.rows.back().beyond = beyond;
  }
  void note(const std::filesystem::path& place, std::string text) {
    checks_.notes.push_back({planned_.take.id, false, place.string(), std::move(text)});
  }
  void note_session(std::string text) { note(planned_.take.session, std::move(text)); }
  void note_calibration(std::string text) { note(planned_.take.calibration, std::move(text)); }

  // Both in the frames that the transforms lead to; NaN for too few.
  double distance_m(std::size_t a, const RigidTransform& of_a, std::size_t b,
                    const RigidTransform& of_b) const {
    std::vector<double> distances_m;
    for (std::size_t k = 0; k < in_sensor_[a].size(); ++k) {
      const double d_m = (of_a * in_sensor_[a][k] - of_b * in_sensor_[b][k]).norm();
      if (std::isfinite(d_m)) distances_m.push_back(d_m);
    }
    return distances_m.size() < kFewestRows ? kNaN : median_of(distances_m);
  }

  // Median distance of the joints as two trackers deliver them, each in its own frame.
  double raw_distance_m(std::size_t a, std::size_t b) const {
    std::vector<double> distances_m;
    const std::size_t step = std::max<std::size_t>(1, bodies_.instants() / kMostViewInstants);
    for (std::size_t i = 0; i < bodies_.instants(); i += step)
      for (const Joint joint : plan_.joints)
        if (bodies_.at(i, a).has(joint) && bodies_.at(i, b).has(joint))
          distances_m.push_back((bodies_.at(i, a).at(joint) - bodies_.at(i, b).at(joint)).norm());
    return distances_m.size() < kFewestRows ? kNaN : median_of(distances_m);
  }

  void find_same_streams() {
    for (std::size_t b = 1; b < sensors_; ++b)
      for (std::size_t a = 0; a < b; ++a) {
        const double apart_m = raw_distance_m(a, b);
        if (!(apart_m < kSameStream_m)) continue;
        add(row(b, "same stream", "m", apart_m, kSameStream_m), true);
        note_session(
            fmt::format("{} and {} hold the same bodies: one stream was recorded twice; leave one out with "
                        "\"sensors\" in the study, and record again",
                        name(a), name(b)));
        leave_out(b);
        break;
      }
  }

  void find_mirrored() {
    std::vector<std::size_t> mirrored;
    double plain_m = 0.0, mirrored_m = 0.0;
    for (const std::size_t s : sound_) {
      std::size_t against = 0, asked = 0;
      for (const std::size_t other : sound_) {
        if (other == s) continue;
        const PointFit fit = fit_points(in_sensor_[s], in_sensor_[other]);
        ++asked;
        if (!(fit.rms_m > kMirrored_m && fit.mirrored_rms_m < kMirroredShare * fit.rms_m)) continue;
        ++against;
        plain_m = fit.rms_m;
        mirrored_m = fit.mirrored_rms_m;
      }
      if (2 * against > asked) mirrored.push_back(s);
    }
    if (mirrored.empty()) return;
    const bool either = sound_.size() == 2;
    if (either) mirrored.resize(1);
    for (const std::size_t s : mirrored) {
      add(row(s, "mirrored", "1", mirrored_m / plain_m, kMirroredShare), true);
      note_session(
          fmt::format("{} sees the person as in a mirror (laid over each other {:.2f} m apart, mirrored "
                      "{:.2f} m); record without mirroring{}",
                      either ? "one of " + name(sound_[0]) + " and " + name(sound_[1]) : name(s), plain_m,
                      mirrored_m, either ? "" : ", or leave it out with \"sensors\" in the study"));
    }
    for (const std::size_t s : mirrored) leave_out(s);
  }

  // Median distances between the sensors' views in the world, with these poses.
  Eigen::MatrixXd distances_m(const std::vector<RigidTransform>& poses) const {
    const auto n = static_cast<Eigen::Index>(sound_.size());
    Eigen::MatrixXd d_m = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index a = 0; a < n; ++a)
      for (Eigen::Index b = 0; b < a; ++b) {
        const std::size_t sa = sound_[static_cast<std::size_t>(a)], sb = sound_[static_cast<std::size_t>(b)];
        const double m = distance_m(sa, poses[sa], sb, poses[sb]);
        d_m(a, b) = d_m(b, a) = std::isfinite(m) ? m : 0.0;
      }
    return d_m;
  }

  bool find_exchanged_poses() {
    const Eigen::MatrixXd as_stated_m = distances_m(planned_.world_from_sensor);
    if (sound_.size() < 2 || as_stated_m.maxCoeff() < kApart_m) return false;
    double least_m = kLeastShare * as_stated_m.sum();
    std::size_t one = 0, other = 0;
    for (const std::size_t b : sound_)
      for (const std::size_t a : sound_) {
        if (a >= b) continue;
        std::vector<RigidTransform> poses = planned_.world_from_sensor;
        std::swap(poses[a], poses[b]);
        if (const double sum_m = distances_m(poses).sum(); sum_m < least_m) {
          least_m = sum_m;
          one = a;
          other = b;
        }
      }
    if (one == other) return false;
    const double pairs = static_cast<double>(sound_.size() * (sound_.size() - 1));
    for (const std::size_t s : {one, other})
      add(row(s, "poses exchanged", "1", least_m / as_stated_m.sum(), kLeastShare), true);
    note_calibration(
        fmt::format("has the poses of {} and {} exchanged, it seems: the sensors' views lie {:.2f} m apart, "
                    "and {:.2f} m with both exchanged; mend it",
                    name(one), name(other), as_stated_m.sum() / pairs, least_m / pairs));
    return true;
  }

  void place_all() {
    for (std::size_t s = 0; s < sensors_; ++s) {
      in_world_.push_back(in_sensor_[s]);
      for (Eigen::Vector3d& point : in_world_[s]) point = planned_.world_from_sensor[s] * point;
    }
  }
  // The mean of the sensors that are sound, without one.
  Points mean_without(std::size_t without) const {
    Points mean(in_world_.front().size());
    for (std::size_t k = 0; k < mean.size(); ++k) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double count = 0.0;
      for (const std::size_t s : sound_)
        if (s != without && in_world_[s][k].allFinite()) {
          sum += in_world_[s][k];
          count += 1.0;
        }
      mean[k] = sum / count;  // NaN without any
    }
    return mean;
  }

  // In the median, from the mean of the other sensors; NaN for too few.
  double apart_m(std::size_t s) const {
    const Points others = mean_without(s);
    std::vector<double> off_m;
    for (std::size_t k = 0; k < others.size(); ++k)
      if (const double m = (others[k] - in_world_[s][k]).norm(); std::isfinite(m)) off_m.push_back(m);
    return off_m.size() < kFewestRows ? kNaN : median_of(off_m);
  }

  // Keeps the sensors that see the person where most others do.
  void find_poses() {
    if (sound_.size() < 2) return;
    const std::vector<std::size_t> all = sound_;
    const Eigen::MatrixXd between_m = distances_m(planned_.world_from_sensor);
    if (between_m.maxCoeff() >= kApart_m) {
      Eigen::Index centre = 0;
      (between_m.array() < kApart_m).rowwise().count().maxCoeff(&centre);
      for (std::size_t s = 0; s < all.size(); ++s)
        if (between_m(centre, static_cast<Eigen::Index>(s)) >= kApart_m) leave_out(all[s]);
      checks_.misplaced = true;
    }
    for (const std::size_t s : all)
      add(row(s, "apart", "m", apart_m(s), kApart_m), std::ranges::find(sound_, s) == sound_.end());
    if (all.size() == 2 && checks_.misplaced) {
      note_calibration(
          fmt::format("{} and {} see the person {:.2f} m apart, by the poses it has: one pose is wrong, "
                      "or one clock is off by more than a second; calibrate again",
                      name(all[0]), name(all[1]), between_m(0, 1)));
      sound_.clear();
      return;
    }
    for (const CheckRow& found : checks_.rows)
      if (found.what == "apart" && found.beyond && std::isfinite(found.value))
        note_calibration(fmt::format(
            "{} sees the person {:.2f} m from where the others do, by the pose it has: the pose "
            "is wrong, or its clock is off by more than a second; calibrate again, or leave it out with "
            "\"sensors\" in the study",
            found.subject, found.value));
  }

  // A sensor that was pushed during the take: its view moves against the others'.
  void find_moved() {
    if (sound_.size() < 2) return;
    double most_m = kMoved_m;
    std::size_t who = sensors_;
    for (const std::size_t s : sound_) {
      const Points others = mean_without(s);
      const std::size_t third = others.size() / 3;
      const auto mean_off = [&](std::size_t first, std::size_t end) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        std::size_t count = 0;
        for (std::size_t k = first; k < end; ++k)
          if (const Eigen::Vector3d off = in_world_[s][k] - others[k]; off.allFinite()) {
            sum += off;
            ++count;
          }
        return count < kFewestRows ? no_point() : Eigen::Vector3d(sum / static_cast<double>(count));
      };
      const double moved_m = (mean_off(others.size() - third, others.size()) - mean_off(0, third)).norm();
      add(row(s, "moved", "m", moved_m, kMoved_m), false);
      if (!(moved_m > most_m)) continue;
      most_m = moved_m;
      who = s;
    }
    if (who == sensors_) return;
    for (CheckRow& found : checks_.rows) found.beyond |= found.what == "moved" && found.subject == name(who);
    note_session(fmt::format(
        "{} moved during the take: its view shifts by {:.2f} m against the others' from the first third to "
        "the last; was it pushed? Record again, or leave it out with \"sensors\" in the study",
        sound_.size() == 2 ? "a sensor" : name(who), most_m));
    leave_out(who);
  }

  // The movements of some joints about each instant.
  Movements movements_of(std::size_t sensor) const {
    const std::size_t instants = std::min(bodies_.instants(), kMostClockInstants);
    const std::size_t first = (bodies_.instants() - instants) / 2;
    const std::size_t step = std::max<std::size_t>(1, joints_.size() / kClockJoints);
    const auto around =
        static_cast<std::size_t>(std::max(1LL, std::llround(kMovement_s * plan_.study.rate_hz)));
    Movements movements{{}, (joints_.size() + step - 1) / step};
    for (std::size_t i = first; i < first + instants; ++i)
      for (std::size_t j = 0; j < joints_.size(); j += step)
        movements.moved_m.push_back(
            i < first + around || i + around >= first + instants
                ? no_point()
                : planned_.world_from_sensor[sensor].rotation *
                      (middle(i + around, sensor, joints_[j]) - middle(i - around, sensor, joints_[j])));
    return movements;
  }

  // Lag of a sensor's movements behind the sum of the others'.
  MovementLag lag_of_sensor(const std::vector<Movements>& movements, std::size_t sensor) const {
    Movements others{Points(movements[sensor].moved_m.size(), Eigen::Vector3d::Zero()),
                     movements[sensor].joints};
    for (const std::size_t s : sound_)
      for (std::size_t k = 0; s != sensor && k < others.moved_m.size(); ++k)
        if (movements[s].moved_m[k].allFinite()) others.moved_m[k] += movements[s].moved_m[k];
    return lag_of(movements[sensor], others, plan_.study.rate_hz);
  }

  void find_clocks() {
    if (sound_.size() < 2) return;
    std::vector<Movements> movements;
    for (std::size_t s = 0; s < sensors_; ++s) movements.push_back(movements_of(s));
    while (sound_.size() >= 2) {
      std::vector<CheckRow> rows;
      double most_s = kClock_s;
      std::size_t who = sensors_;
      for (const std::size_t s : sound_) {
        const auto [lag_s, sigma_s] = lag_of_sensor(movements, s);
        const double reach_s = kClockSigmas * sigma_s;
        rows.push_back(row(s, "lag", "s", lag_s, kClock_s));
        rows.back().low = lag_s - reach_s;
        rows.back().high = lag_s + reach_s;
        const bool is_sure = std::abs(lag_s) - reach_s > kClockSurely_s;
        if (!is_sure || std::abs(lag_s) <= most_s) continue;
        most_s = std::abs(lag_s);
        who = s;
      }
      for (const CheckRow& found : rows)
        if (who == sensors_ || found.subject == name(who)) checks_.rows.push_back(found);
      if (who == sensors_) return;
      CheckRow& late = checks_.rows.back();
      late.beyond = true;
      note_session(fmt::format(
          "{} shows movements {:.2f} s {} than {}: is its clock the recording host's? Record again, or leave "
          "it out with \"sensors\" in the study",
          name(who), most_s, late.value > 0.0 ? "later" : "earlier",
          sound_.size() == 2 ? name(sound_[0] == who ? sound_[1] : sound_[0]) : std::string("the others")));
      leave_out(who);
    }
  }

  // The ranges that sensors measure, over the distances to where their rays meet: by sensor, medians.
  std::vector<double> range_ratios() const {
    std::vector<std::vector<double>> ratios(sensors_);
    for (std::size_t k = 0; k < in_sensor_.front().size(); ++k) {
      Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
      Eigen::Vector3d right = Eigen::Vector3d::Zero();
      double rays = 0.0;
      for (const std::size_t s : sound_) {
        if (!in_sensor_[s][k].allFinite()) continue;
        const RigidTransform& pose = planned_.world_from_sensor[s];
        const Eigen::Vector3d ray = pose.rotation * in_sensor_[s][k].normalized();
        const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
        normal += across;
        right += across * pose.translation_m;
        rays += 1.0;
      }
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normal);
      if (rays < 2.0 || eigen.eigenvalues()[0] < kLeastCrossing) continue;
      const Eigen::Vector3d meet = normal.ldlt().solve(right);
      for (const std::size_t s : sound_)
        if (in_sensor_[s][k].allFinite())
          ratios[s].push_back(in_sensor_[s][k].norm() /
                              (meet - planned_.world_from_sensor[s].translation_m).norm());
    }
    std::vector<double> medians;
    for (const std::vector<double>& list : ratios)
      medians.push_back(list.size() < kFewestRows ? kNaN : median_of(list));
    return medians;
  }

  static std::string size_of(double ratio) {
    return fmt::format("{:.1f} % too {}", 100.0 * std::abs(ratio - 1.0), ratio > 1.0 ? "long" : "short");
  }

  void find_scales() {
    if (sound_.size() < 2) return;
    const std::vector<double> ratio = range_ratios();
    const auto ratios_without = [&](std::size_t without) {
      std::vector<double> list;
      for (const std::size_t s : sound_)
        if (s != without && std::isfinite(ratio[s])) list.push_back(ratio[s]);
      return list;
    };
    for (const std::size_t s : sound_) {
      const std::vector<double> others = ratios_without(s);
      if (others.size() < 2 || !std::isfinite(ratio[s])) continue;
      const double usual = median_of(others), off = ratio[s] / usual;
      const double limit = std::max(kOneRange, kSigmas * spread_of(others, usual));
      const bool beyond = std::abs(off - 1.0) > limit;
      add(row(s, "range scale", "1", off, limit), beyond);
      if (beyond)
        note_session(
            fmt::format("{} measures {}, by where the sensors' rays meet: are its depths in metres, and its "
                        "joints unscaled? Leave it out with \"sensors\" in the study",
                        name(s), size_of(off)));
    }
    const std::vector<double> all = ratios_without(sensors_);
    if (all.size() < 2) return;
    const double scale = median_of(all);
    const double sigma = spread_of(all, scale) / std::sqrt(static_cast<double>(all.size()));
    const bool beyond = std::abs(scale - 1.0) > std::max(kAllRanges, kSigmas * sigma);
    CheckRow of_all = row(0, "range scale", "1", scale, kAllRanges);
    of_all.subject = "all";
    of_all.low = scale - student_quantile(all.size() - 1) * sigma;
    of_all.high = scale + student_quantile(all.size() - 1) * sigma;
    add(of_all, beyond);
    if (beyond)
      note_calibration(
          fmt::format("places the sensors too far {}: all measure {}, by where their rays meet; is its "
                      "length right (the wand's, the unit)? Calibrate again",
                      scale < 1.0 ? "apart" : "together", size_of(scale)));
  }

  const Plan& plan_;
  const PlannedTake& planned_;
  const BodyTracks& bodies_;
  std::size_t sensors_;
  std::vector<Joint> joints_;                 // those of the middle, and one of each pair
  std::vector<Points> in_sensor_, in_world_;  // by sensor: instants x joints, the middles of both sides
  std::vector<std::size_t> sound_;            // of whom nothing bad is known yet
  SensorChecks checks_;
};

}  // namespace

SensorChecks check_sensors(const Plan& plan, const PlannedTake& planned, const BodyTracks& bodies) {
  if (bodies.sensors() < 2 || bodies.instants() == 0) return {};
  return SensorChecker(plan, planned, bodies).run();
}

}  // namespace trilat
