// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/angle_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "evaluators/metrics/joint_angles.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {
namespace {

constexpr std::size_t kOfTrunk = 4;  // points: both hips, both shoulders

std::optional<std::vector<std::size_t>> places_of(const TakeHead& head,
                                                  const std::vector<std::string>& names) {
  std::vector<std::size_t> places;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(head.joints, name);
    if (found == head.joints.end()) return std::nullopt;
    places.push_back(static_cast<std::size_t>(found - head.joints.begin()));
  }
  return places;
}

// `point(place)` gives a point.
double angle_of(const std::vector<std::size_t>& places, const auto& point) {
  if (places.size() != kOfTrunk) return flexion_rad(point(places[0]), point(places[1]), point(places[2]));
  const Eigen::Vector3d hips = 0.5 * (point(places[0]) + point(places[1])),
                        shoulders = 0.5 * (point(places[2]) + point(places[3]));
  return inclination_rad(hips, shoulders);
}

void widen(double& least, double& most, double value) {
  least = std::fmin(least, value);
  most = std::fmax(most, value);
}

}  // namespace

AngleErrors::AngleErrors(const TakeHead& head, const std::string& participant, bool level)
    : joints_(head.joints.size()), methods_(head.methods.size()) {
  struct Flexion {
    const char *name, *upper, *joint, *lower;
  };
  for (const auto& [name, upper, joint, lower] : {Flexion{"knee flexion", "hip", "knee", "ankle"},
                                                  Flexion{"elbow flexion", "shoulder", "elbow", "wrist"},
                                                  Flexion{"hip flexion", "shoulder", "hip", "knee"}})
    for (const char* side : {"_left", "_right"})
      if (auto places = places_of(
              head, {std::string(upper) + side, std::string(joint) + side, std::string(lower) + side}))
        angles_.push_back({name, std::move(*places)});
  if (auto places = places_of(head, {"hip_left", "hip_right", "shoulder_left", "shoulder_right"});
      places && level)
    angles_.push_back({"trunk inclination", std::move(*places)});
  for (const Angle& angle : angles_)
    if (names_.empty() || names_.back() != angle.name) names_.push_back(angle.name);
  for (const std::string& name : names_)
    for (const std::string& method : head.methods)
      sums_.push_back({participant, head.condition, name, method});
  for (std::size_t s = 0; s < head.status_names.size(); ++s)
    usable_.push_back(is_usable(static_cast<SolveStatus>(s)));
}

void AngleErrors::add(const SampleBlock& block) {
  for (std::size_t i = 0; i < block.instants; ++i)
    for (const Angle& angle : angles_) {
      const double truth = angle_of(angle.points, [&](std::size_t j) {
        return Eigen::Vector3d(Eigen::Map<const Eigen::Vector3d>(&block.truth_m[(i * joints_ + j) * 3]));
      });
      if (!std::isfinite(truth)) continue;
      const auto name = static_cast<std::size_t>(std::ranges::find(names_, angle.name) - names_.begin());
      for (std::size_t m = 0; m < methods_; ++m) {
        const double estimate = angle_of(angle.points, [&](std::size_t j) -> Eigen::Vector3d {
          const std::size_t slot = (i * joints_ + j) * methods_ + m;
          if (!usable_[block.status[slot]]) return Eigen::Vector3d::Constant(kNaN);
          return Eigen::Map<const Eigen::Vector3d>(&block.estimate_m[slot * 3]);
        });
        if (!std::isfinite(estimate)) continue;
        AngleSums& sums = sums_[name * methods_ + m];
        const double error = estimate - truth;
        ++sums.n;
        sums.error += error;
        sums.error2 += error * error;
        sums.absolute += std::abs(error);
        sums.truth += truth;
        widen(sums.truth_least, sums.truth_most, truth);
        widen(sums.least, sums.most, estimate);
      }
    }
}

std::vector<AngleSums> AngleErrors::sums() const {
  std::vector<AngleSums> sums;
  std::ranges::copy_if(sums_, std::back_inserter(sums), [](const AngleSums& one) { return one.n > 0; });
  return sums;
}

}  // namespace trilat
