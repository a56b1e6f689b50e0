// SPDX-License-Identifier: MIT
#include "pipeline/errors/take_angles.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "evaluators/metrics/body_metrics.h"

namespace trilat {
namespace {

constexpr std::size_t kOfTrunk = 4;  // points: both hips, both shoulders

std::optional<std::vector<std::size_t>> joints_of(const TakeHead& head,
                                                  const std::vector<std::string>& names) {
  std::vector<std::size_t> joints;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(head.joints, name);
    if (found == head.joints.end()) return std::nullopt;
    joints.push_back(static_cast<std::size_t>(found - head.joints.begin()));
  }
  return joints;
}

// `point(joint)` gives its position.
double angle_rad(const std::vector<std::size_t>& joints, const auto& point) {
  if (joints.size() != kOfTrunk) return flexion_rad(point(joints[0]), point(joints[1]), point(joints[2]));
  const Eigen::Vector3d hips = 0.5 * (point(joints[0]) + point(joints[1])),
                        shoulders = 0.5 * (point(joints[2]) + point(joints[3]));
  return inclination_rad(hips, shoulders);
}

}  // namespace

void TakeAngles::Extremes::add(double value) {
  least = std::fmin(least, value);
  largest = std::fmax(largest, value);
}

TakeAngles::TakeAngles(const TakeHead& head) : methods_(head.methods.size()) {
  const auto add = [&](const std::string& name, const std::vector<std::string>& joints) {
    auto found = joints_of(head, joints);
    if (!found) return;
    if (names_.empty() || names_.back() != name) names_.push_back(name);
    angles_.push_back({names_.size() - 1, std::move(*found)});
  };
  for (const std::string side : {"_left", "_right"})
    add("knee flexion", {"hip" + side, "knee" + side, "ankle" + side});
  for (const std::string side : {"_left", "_right"})
    add("elbow flexion", {"shoulder" + side, "elbow" + side, "wrist" + side});
  for (const std::string side : {"_left", "_right"})
    add("hip flexion", {"shoulder" + side, "hip" + side, "knee" + side});
  if (head.is_upright) add("trunk inclination", {"hip_left", "hip_right", "shoulder_left", "shoulder_right"});
  sums_.resize(names_.size() * methods_);
}

void TakeAngles::add(const Window& w) {
  for (std::uint64_t i = w.first; i < w.end; ++i)
    for (const Angle& angle : angles_) {
      const double truth_rad =
          angle_rad(angle.joints, [&](std::size_t j) { return Eigen::Vector3d(w.truth_m(i, j)); });
      if (!std::isfinite(truth_rad)) continue;
      for (std::size_t m = 0; m < methods_; ++m) {
        const double estimate_rad = angle_rad(angle.joints, [&](std::size_t j) -> Eigen::Vector3d {
          const std::size_t slot = w.slot(i, j, m);
          if (!is_usable(w.status(slot))) return Eigen::Vector3d::Constant(kNaN);
          return w.estimate_m(slot);
        });
        if (!std::isfinite(estimate_rad)) continue;
        Sums& sums = sums_[angle.name * methods_ + m];
        sums.error.add(estimate_rad - truth_rad);
        sums.truth.add(truth_rad);
        sums.estimates.add(estimate_rad);
        sums.truths.add(truth_rad);
      }
    }
}

void TakeAngles::end_block(const Put& put) {
  for (std::size_t k = 0; k < sums_.size(); ++k) {
    put(sums_[k].error, k / methods_, k % methods_, Measure::angle);
    put(sums_[k].truth, k / methods_, k % methods_, Measure::true_angle);
  }
}

void TakeAngles::end_take(const Put& put) {
  for (std::size_t k = 0; k < sums_.size(); ++k) {
    if (!std::isfinite(sums_[k].estimates.range())) continue;
    ErrorSums range, of_truth;
    range.add(sums_[k].estimates.range());
    of_truth.add(sums_[k].truths.range());
    put(range, k / methods_, k % methods_, Measure::motion_range);
    put(of_truth, k / methods_, k % methods_, Measure::true_motion_range);
  }
}

}  // namespace trilat
