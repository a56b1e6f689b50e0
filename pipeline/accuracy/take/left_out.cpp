// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/left_out.h"

#include <algorithm>
#include <cmath>

#include "datasets/base/error.h"
#include "evaluators/metrics/cluster_ratios.h"

namespace trilat {
namespace {

Eigen::Vector3d point_at(const std::vector<double>& coordinates, std::size_t k) {
  return Eigen::Map<const Eigen::Vector3d>(coordinates.data() + 3 * k);
}

void add(PredictionSums& sums, const Eigen::Vector3d& predicted_in_sensor_m,
         const Eigen::Vector3d& seen_in_sensor_m) {
  const Eigen::Vector3d ray = seen_in_sensor_m.normalized();
  const double along_m = predicted_in_sensor_m.norm() - seen_in_sensor_m.norm();
  ++sums.n;
  sums.range_m += along_m;
  sums.abs_range_m += std::abs(along_m);
  sums.bearing_m += predicted_in_sensor_m.cross(ray).norm();
}

// The mean of what `sum` adds up in these entries, participants as clusters. `signed_sum`: it may be below
// zero.
Estimate mean_of(const std::vector<const PredictionSums*>& entries, double PredictionSums::*sum,
                 std::uint64_t PredictionSums::*n, bool signed_sum) {
  WeightedRatio mean;
  std::vector<std::string> participants;
  for (const PredictionSums* entry : entries) {
    const auto found = std::ranges::find(participants, entry->participant);
    const auto k = static_cast<std::size_t>(found - participants.begin());
    if (found == participants.end()) {
      participants.push_back(entry->participant);
      mean.numerator.push_back(0.0);
      mean.denominator.push_back(0.0);
    }
    mean.numerator[k] += entry->*sum;
    mean.denominator[k] += static_cast<double>(entry->*n);
  }
  const ContrastEstimate estimate = solve_contrast({{mean}, {}});
  return {estimate.value, signed_sum ? estimate.low() : estimate.low_of_size(), estimate.high()};
}

}  // namespace

Predictions::Predictions(const Plan& plan, const PlannedTake& planned, std::size_t left_out)
    : plan_(plan), sensor_from_world_(planned.world_from_sensor[left_out].inverse()) {
  Track track;
  track.last_m.resize(plan.joints.size());
  for (auto& last_m : track.last_m) last_m.fill(Eigen::Vector3d::Constant(kNaN));
  for (std::size_t child = 0; child < plan.joints.size(); ++child)
    if (const auto parent = parent_of(plan.joints[child])) {
      const auto found = std::ranges::find(plan.joints, *parent);
      if (found != plan.joints.end())
        track.bones.push_back({static_cast<std::size_t>(found - plan.joints.begin()), child, {}});
    }
  for (const Method& method : plan.methods) {
    sums_.push_back({planned.take.participant, planned.take.activity, method.spec.name});
    tracks_.push_back(track);
  }
}

void Predictions::add(const SampleBlock& block) {
  std::vector<Eigen::Vector3d> joints_m(plan_.joints.size());
  for (std::size_t i = 0; i < block.instants; ++i)
    for (std::size_t m = 0; m < sums_.size(); ++m) {
      for (std::size_t j = 0; j < joints_m.size(); ++j) {
        const std::size_t row = i * joints_m.size() + j, slot = row * sums_.size() + m;
        const bool usable = is_usable(static_cast<SolveStatus>(block.status[slot]));
        joints_m[j] = usable ? point_at(block.estimate_m, slot) : Eigen::Vector3d::Constant(kNaN);
        const Eigen::Vector3d seen_m = point_at(block.truth_m, row);
        if (usable && seen_m.allFinite())
          trilat::add(sums_[m], sensor_from_world_ * joints_m[j], sensor_from_world_ * seen_m);
      }
      add(m, joints_m);
    }
}

void Predictions::add(std::size_t method, std::span<const Eigen::Vector3d> joints_m) {
  for (Bone& bone : tracks_[method].bones)
    if (const double length_m = (joints_m[bone.child] - joints_m[bone.parent]).norm();
        std::isfinite(length_m))
      bone.length.add(length_m);
  for (std::size_t j = 0; j < joints_m.size(); ++j) {
    auto& last_m = tracks_[method].last_m[j];
    std::shift_right(last_m.begin(), last_m.end(), 1);
    last_m[0] = joints_m[j];
    const double jerk = jerk_m_s3(last_m[3], last_m[2], last_m[1], last_m[0], plan_.study.rate_hz);
    if (!std::isfinite(jerk)) continue;
    ++sums_[method].jerk_n;
    sums_[method].jerk_m_s3 += jerk;
  }
}

std::vector<PredictionSums> Predictions::sums() const {
  std::vector<PredictionSums> sums = sums_;
  for (std::size_t m = 0; m < sums.size(); ++m)
    for (const Bone& bone : tracks_[m].bones) {
      const auto n = static_cast<std::uint64_t>(bone.length.count());
      if (n < 2) continue;
      sums[m].bone_n += n;
      sums[m].bone_m += static_cast<double>(n) * bone.length.standard_deviation_m();
    }
  return sums;
}

std::vector<PredictionRow> prediction_rows(const std::vector<PredictionSums>& sums) {
  std::vector<PredictionRow> rows;
  std::vector<std::vector<const PredictionSums*>> entries;
  for (const PredictionSums& one : sums) {
    const auto found = std::ranges::find_if(rows, [&](const PredictionRow& row) {
      return row.condition == one.condition && row.method == one.method;
    });
    const auto k = static_cast<std::size_t>(found - rows.begin());
    if (found == rows.end()) {
      rows.push_back({.condition = one.condition, .method = one.method});
      entries.emplace_back();
    }
    rows[k].n += one.n;
    entries[k].push_back(&one);
  }
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto mean = [&](double PredictionSums::*sum,
                          std::uint64_t PredictionSums::*n = &PredictionSums::n) {
      return mean_of(entries[k], sum, n, sum == &PredictionSums::range_m);
    };
    rows[k].range_m = mean(&PredictionSums::abs_range_m);
    rows[k].bearing_m = mean(&PredictionSums::bearing_m);
    rows[k].mean_range_m = mean(&PredictionSums::range_m);
    rows[k].bone_m = mean(&PredictionSums::bone_m, &PredictionSums::bone_n);
    rows[k].jerk_m_s3 = mean(&PredictionSums::jerk_m_s3, &PredictionSums::jerk_n);
  }
  return rows;
}

}  // namespace trilat
