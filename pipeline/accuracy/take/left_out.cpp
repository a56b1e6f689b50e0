// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/left_out.h"

#include <algorithm>
#include <cmath>

#include "datasets/base/error.h"
#include "evaluators/metrics/cluster_ratios.h"

namespace trilat {
namespace {

// By rig sensor.
std::size_t left_out_sensor(const Plan& plan, const PlannedTake& planned) {
  return static_cast<std::size_t>(std::ranges::find(plan.rig, planned.take.left_out) - plan.rig.begin());
}

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

// The mean of what `sum` adds up in these entries, participants as clusters.
ContrastEstimate mean_of(const std::vector<const PredictionSums*>& entries, double PredictionSums::*sum) {
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
    mean.denominator[k] += static_cast<double>(entry->n);
  }
  return solve_contrast({{mean}, {}});
}

}  // namespace

void leave_out(const Plan& plan, const PlannedTake& planned, TakeData& data) {
  if (planned.take.left_out.empty()) return;
  const std::size_t s = left_out_sensor(plan, planned);
  data.truth_m.assign(data.time.size() * plan.joints.size(), Eigen::Vector3d::Constant(kNaN));
  bool any = false;
  for (std::size_t i = 0; i < data.time.size(); ++i) {
    ObservedBody& body = data.bodies.at(i, s);
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      const Joint joint = plan.joints[j];
      if (body.state[static_cast<std::size_t>(joint)] != TrackingState::tracked) continue;
      data.truth_m[i * plan.joints.size() + j] = planned.world_from_sensor[s] * body.at(joint);
      any = true;
    }
    body = {};
  }
  if (!any)
    throw InputError(planned.take.session.string(), "sensor \"" + planned.take.left_out +
                                                        "\" never tracks a joint that is asked for, so that "
                                                        "there is nothing to predict");
}

void add_predictions(const Plan& plan, const PlannedTake& planned, const SampleBlock& block,
                     std::vector<PredictionSums>& sums) {
  if (planned.take.left_out.empty()) return;
  if (sums.empty())
    for (const Method& method : plan.methods)
      sums.push_back({planned.take.participant, planned.take.activity, method.spec.name});
  const RigidTransform sensor_from_world =
      planned.world_from_sensor[left_out_sensor(plan, planned)].inverse();
  for (std::size_t row = 0; row < block.instants * plan.joints.size(); ++row) {
    const Eigen::Vector3d seen_m = point_at(block.truth_m, row);
    if (!seen_m.allFinite()) continue;
    for (std::size_t m = 0; m < sums.size(); ++m) {
      const std::size_t slot = row * sums.size() + m;
      if (is_usable(static_cast<SolveStatus>(block.status[slot])))
        add(sums[m], sensor_from_world * point_at(block.estimate_m, slot), sensor_from_world * seen_m);
    }
  }
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
    const ContrastEstimate range = mean_of(entries[k], &PredictionSums::abs_range_m);
    const ContrastEstimate bearing = mean_of(entries[k], &PredictionSums::bearing_m);
    rows[k].range_m = range.value;
    rows[k].range_low_m = range.low();
    rows[k].range_high_m = range.high();
    rows[k].bearing_m = bearing.value;
    rows[k].bearing_low_m = bearing.low();
    rows[k].bearing_high_m = bearing.high();
    rows[k].mean_range_m = mean_of(entries[k], &PredictionSums::range_m).value;
  }
  return rows;
}

}  // namespace trilat
