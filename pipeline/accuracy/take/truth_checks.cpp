// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "evaluators/alignment/alignment.h"
#include "evaluators/metrics/quantiles.h"
#include "evaluators/metrics/student.h"
#include "pipeline/accuracy/take/take_checks.h"

namespace trilat {
namespace {

constexpr std::size_t kMostTruthInstants = 400;  // that are looked at, spread over the take
constexpr std::size_t kFewest = 30;              // instants of a joint; fewer are not checked
constexpr int kRounds = 6;                       // of weighting the joints by how well they fit
constexpr double kWell_m = 0.1;                  // a joint that is so far off counts half
// Beyond these the truth contradicts the sensors. Markers and trackers mean different points of a joint,
// which makes up to a decimetre.
constexpr double kScale = 0.075, kScaleAlpha = 0.01;
constexpr double kExchanged_m = 0.1, kExchangedShare = 0.6;
constexpr double kFar_m = 0.25, kFarTimes = 3.0;
constexpr double kMovesTimes = 1.4;
// Root mean square distance of the joints, turned onto each other; and how much smaller it is for a mirrored
// truth.
constexpr double kReflected_m = 0.1, kReflectedShare = 0.5;
// One Kinect v2 beside Vicon: up to 1.11 in 14 of 89 sound takes (docs/explanation/real_recordings.md).
constexpr double kMarkersOff = 0.15;

using Points = std::vector<Eigen::Vector3d>;

struct Unit {
  double times;  // how much too large the numbers are
  const char* what;
};
constexpr std::array kUnits{Unit{1.0 / 0.3048, "feet"},
                            Unit{1.0 / 0.0254, "inches"},
                            Unit{100.0, "centimetres"},
                            Unit{1000.0, "millimetres"},
                            Unit{0.01, "metres that the header calls centimetres"},
                            Unit{0.001, "metres that the header calls millimetres"}};
constexpr std::array kYards{Unit{1.0 / 0.9144, "yards"}, Unit{0.9144, "metres that were taken for yards"}};
constexpr double kNearUnit = 0.03;
// Markers off the joints explain as much as yards do: these are named only where the scale is known closely.
constexpr double kNearYards = 0.005, kYardsSigma = 0.004;

// `sigma` of the scale; NaN where it is not known.
std::string unit_text(double times, double sigma) {
  for (const Unit& unit : kUnits)
    if (std::abs(times / unit.times - 1.0) < kNearUnit) return fmt::format(" (as {} are)", unit.what);
  for (const Unit& unit : kYards)
    if (std::abs(times / unit.times - 1.0) < kNearYards && sigma < kYardsSigma)
      return fmt::format(" (as {} are; markers that stand off the joints do that, too)", unit.what);
  return std::abs(times - 1.0) < kMarkersOff ? " (markers that stand off the joints do that, too)" : "";
}

double median_distance_m(const Points& a, const Points& b) {
  std::vector<double> distances_m;
  for (std::size_t k = 0; k < a.size(); ++k)
    if (const double m = (a[k] - b[k]).norm(); std::isfinite(m)) distances_m.push_back(m);
  return distances_m.size() < kFewest ? kNaN : quantiles_of(distances_m, {0.5})[0];
}

// Root mean square about the mean, of what both have.
double movement_m(const Points& of, const Points& where) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double count = 0.0, squares_m2 = 0.0;
  for (std::size_t k = 0; k < of.size(); ++k)
    if (of[k].allFinite() && where[k].allFinite()) {
      mean += of[k];
      count += 1.0;
    }
  mean /= count;
  for (std::size_t k = 0; k < of.size(); ++k)
    if (of[k].allFinite() && where[k].allFinite()) squares_m2 += (of[k] - mean).squaredNorm();
  return std::sqrt(squares_m2 / count);
}

// By joint of the plan, at the same instants.
struct Both {
  std::vector<Points> seen, truth;
};

Both both_of(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  const std::size_t joints = plan.joints.size(), sensors = data.bodies.sensors();
  Both both{std::vector<Points>(joints), std::vector<Points>(joints)};
  const std::size_t step = std::max<std::size_t>(1, data.time.size() / kMostTruthInstants);
  for (std::size_t i = 0; i < data.time.size(); i += step)
    for (std::size_t j = 0; j < joints; ++j) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double count = 0.0;
      for (std::size_t s = 0; s < sensors; ++s) {
        const ObservedBody& body = data.bodies.at(i, s);
        if (body.state[static_cast<std::size_t>(plan.joints[j])] != TrackingState::tracked) continue;
        sum += planned.world_from_sensor[s] * body.at(plan.joints[j]);
        count += 1.0;
      }
      both.seen[j].push_back(sum / count);  // NaN without any
      both.truth[j].push_back(data.truth(i, j, joints));
    }
  return both;
}

Points joined(const std::vector<Points>& of_joints) {
  Points all;
  for (const Points& points : of_joints) all.insert(all.end(), points.begin(), points.end());
  return all;
}

// One fit of all joints, each with a weight that falls with its median distance: a joint in another unit, or
// two that are exchanged, do not turn the rest.
PointFit fit_joints(const Both& both) {
  const Points seen = joined(both.seen), truth = joined(both.truth);
  std::vector<double> weight(seen.size(), 1.0);
  PointFit fit;
  for (int round = 0; round < kRounds; ++round) {
    fit = fit_points(seen, truth, weight);
    for (std::size_t j = 0, k = 0; j < both.seen.size(); ++j) {
      Points there = both.seen[j];
      for (Eigen::Vector3d& point : there) point = fit.b_from_a * point;
      const double off_m = median_distance_m(there, both.truth[j]);
      const double w = std::isfinite(off_m) ? 1.0 / (1.0 + off_m * off_m / (kWell_m * kWell_m)) : 0.0;
      for (std::size_t n = 0; n < there.size(); ++n) weight[k++] = w;
    }
  }
  return fit;
}

// The scale's standard deviation, by leaving out each joint with that of the other side in turn: what
// trackers and markers mean by a joint differs by joint.
double scale_sigma(const std::vector<Joint>& joints, const Both& both, std::size_t& clusters) {
  std::vector<double> scales;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto other = std::ranges::find(joints, mirror_of(joints[j])) - joints.begin();
    if (static_cast<std::size_t>(other) < j) continue;
    Both rest;
    for (std::size_t k = 0; k < joints.size(); ++k)
      if (k != j && static_cast<std::ptrdiff_t>(k) != other) {
        rest.seen.push_back(both.seen[k]);
        rest.truth.push_back(both.truth[k]);
      }
    if (const double scale = fit_joints(rest).scale; std::isfinite(scale)) scales.push_back(scale);
  }
  clusters = scales.size();
  if (clusters < 2) return kNaN;
  const Eigen::Map<const Eigen::ArrayXd> k(scales.data(), static_cast<Eigen::Index>(scales.size()));
  const auto n = static_cast<double>(clusters);
  return std::sqrt((n - 1.0) / n * (k - k.mean()).square().sum());
}

class TruthChecker {
 public:
  TruthChecker(const Plan& plan, const PlannedTake& planned, const TakeData& data)
      : plan_(plan), planned_(planned), both_(both_of(plan, planned, data)) {}

  TakeChecks run() {
    if (find_mirrored()) return std::move(checks_);  // nothing else is known of it then
    const PointFit fit = fit_joints(both_);
    if (!std::isfinite(fit.scale)) return std::move(checks_);
    double sigma = kNaN;
    const bool is_scaled = find_scale(fit.scale, sigma);
    if (is_scaled)
      note(planned_.take.mocap, fmt::format("shows movements and a body {:.3f} times as large as the sensors "
                                            "do{}; is the export's unit right?",
                                            fit.scale, unit_text(fit.scale, sigma)));
    lay_over(fit, is_scaled ? fit.scale : 1.0);
    find_exchanged();
    find_far();
    return std::move(checks_);
  }

 private:
  bool find_mirrored() {
    const PointFit fit = fit_points(joined(both_.seen), joined(both_.truth));
    const double share = fit.mirrored_rms_m / fit.rms_m;
    const bool beyond = fit.rms_m > kReflected_m && share < kReflectedShare;
    add({.what = "mirrored", .unit = "1", .value = share, .limit = kReflectedShare, .beyond = beyond});
    if (!beyond) return false;
    note(planned_.take.mocap,
         fmt::format("is mirrored, it seems: turned onto what the sensors see it lies {:.2f} m off, and "
                     "{:.2f} m off when it is mirrored first; export it with right-handed axes (or, if every "
                     "left joint is mapped to the right, mend the mapping)",
                     fit.rms_m, fit.mirrored_rms_m));
    return true;
  }
  // Whether the scale is beyond doubt not 1. Its uncertainty is looked at only where it may matter.
  bool find_scale(double scale, double& sigma) {
    CheckRow row{.what = "unit", .unit = "1", .value = scale, .limit = kScale};
    if (std::abs(scale - 1.0) > kScale) {
      std::size_t clusters = 0;
      sigma = scale_sigma(plan_.joints, both_, clusters);
      if (clusters >= 2) {
        row.low = scale - student_quantile(clusters - 1) * sigma;
        row.high = scale + student_quantile(clusters - 1) * sigma;
        row.beyond = std::abs(scale - 1.0) > student_quantile(clusters - 1, kScaleAlpha) * sigma;
      }
    }
    add(row);
    return row.beyond;
  }
  void add(CheckRow row) {
    row.take = planned_.take.id;
    if (row.subject.empty()) row.subject = "mocap";
    checks_.rows.push_back(std::move(row));
  }
  void add_joint(std::size_t j, const char* what, double limit_m, bool beyond) {
    add({.subject = name(j),
         .what = what,
         .unit = "m",
         .value = off_m_[j],
         .limit = limit_m,
         .beyond = beyond});
  }
  void note(const std::filesystem::path& place, std::string text) {
    checks_.notes.push_back({planned_.take.id, false, place.string(), std::move(text)});
  }
  std::string name(std::size_t j) const { return std::string(name_of(plan_.joints[j])); }
  std::size_t joints() const { return plan_.joints.size(); }

  // Moves what the sensors see over the truth.
  void lay_over(const PointFit& fit, double scale) {
    Eigen::Vector3d mean_seen = Eigen::Vector3d::Zero();
    double count = 0.0;
    for (const Points& points : both_.seen)
      for (const Eigen::Vector3d& point : points)
        if (point.allFinite()) {
          mean_seen += point;
          count += 1.0;
        }
    mean_seen /= count;
    for (Points& points : both_.seen)
      for (Eigen::Vector3d& point : points)
        point = fit.b_from_a * Eigen::Vector3d(mean_seen + scale * (point - mean_seen));
    for (std::size_t j = 0; j < joints(); ++j)
      off_m_.push_back(median_distance_m(both_.seen[j], both_.truth[j]));
  }

  void find_exchanged() {
    for (std::size_t j = 0; j < joints(); ++j)
      for (std::size_t k = j + 1; k < joints(); ++k) {
        if (!(off_m_[j] > kExchanged_m && off_m_[k] > kExchanged_m)) continue;
        const double there_m = median_distance_m(both_.seen[j], both_.truth[k]);
        const double back_m = median_distance_m(both_.seen[k], both_.truth[j]);
        if (!(there_m < kExchangedShare * off_m_[j] && back_m < kExchangedShare * off_m_[k])) continue;
        note(planned_.take.mapping,
             fmt::format("has {} and {} exchanged, it seems: they lie {:.2f} and {:.2f} m from where the "
                         "sensors see them, and {:.2f} and {:.2f} m the other way round; mend the mapping",
                         name(j), name(k), off_m_[j], off_m_[k], there_m, back_m));
        for (const std::size_t of : {j, k}) {
          add_joint(of, "exchanged", kExchanged_m, true);
          off_m_[of] = kNaN;
        }
      }
  }

  void find_far() {
    std::vector<double> known;
    for (const double m : off_m_)
      if (std::isfinite(m)) known.push_back(m);
    if (known.size() < 3) return;
    const double usual_m = quantiles_of(known, {0.5})[0];
    for (std::size_t j = 0; j < joints(); ++j) {
      const double limit_m = std::max(kFar_m, kFarTimes * usual_m);
      const bool beyond = off_m_[j] > limit_m;
      if (std::isfinite(off_m_[j])) add_joint(j, "place", limit_m, beyond);
      if (!beyond) continue;
      const double times =
          movement_m(both_.truth[j], both_.seen[j]) / movement_m(both_.seen[j], both_.truth[j]);
      if (times > kMovesTimes || times < 1.0 / kMovesTimes)
        note(planned_.take.mocap,
             fmt::format(
                 "moves {} {:.2f} times as far as the sensors see it move{}; is the unit of its asset right?",
                 name(j), times, unit_text(times, kNaN)));
      else
        note(planned_.take.mapping,
             fmt::format("maps {} to what lies {:.2f} m from where the sensors see it, other joints {:.2f} m "
                         "in the median; is it the right asset?",
                         name(j), off_m_[j], usual_m));
    }
  }

  const Plan& plan_;
  const PlannedTake& planned_;
  Both both_;
  std::vector<double> off_m_;  // by joint, in the median, of what is laid over the truth
  TakeChecks checks_;
};

}  // namespace

TakeChecks check_truth(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  return TruthChecker(plan, planned, data).run();
}

}  // namespace trilat
